// NamedObjects: objects that the application registered by name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "weir/join.hpp"

namespace weir::infer {

// Thread-safe. The mutex is not held while code of an object runs.
template <class T>
class NamedObjects {
 public:
  // Returns false if the name is taken.
  bool add(const std::string& name, T object) {
    std::lock_guard lock(mutex_);
    return entries_.try_emplace(name, std::move(object)).second;
  }
  // Returns the removed object; nullopt if the name is unknown.
  std::optional<T> remove(std::string_view name) {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(name);
    if (found == entries_.end()) return std::nullopt;
    std::optional<T> removed(std::move(found->second));
    entries_.erase(found);
    return removed;
  }
  std::optional<T> find(std::string_view name) const {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(name);
    return found == entries_.end() ? std::nullopt : std::optional(found->second);
  }
  std::vector<std::string> names() const {
    std::lock_guard lock(mutex_);
    std::vector<std::string> out;
    for (const auto& [name, object] : entries_) out.push_back(name);
    return out;
  }
  // "one of: a, b"; "one of: none".
  std::string one_of() const {
    const std::string text = join(names(), ", ");
    return "one of: " + (text.empty() ? "none" : text);
  }

 private:
  mutable std::mutex mutex_;  // guards entries_
  std::map<std::string, T, std::less<>> entries_;
};

}  // namespace weir::infer
