// NamedFunctions: functions that a program registered in this process, with their data.
#pragma once
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <string_view>

#include "weir/codes.h"

namespace weir::infer {

// Thread-safe. No function is called while the mutex is held.
template <class Function>
class NamedFunctions {
 public:
  struct Entry {
    Function function;
    void* data;
  };

  // What the functions of the C ABI return; `unknown` is the code for a name that is not there.
  int add(const char* name, Function function, void* data) noexcept {
    if (!name || !*name || !function) return -WEIR_OPTION_VALUE;
    try {
      std::lock_guard lock(mutex_);
      const bool added = entries_.try_emplace(name, Entry{function, data}).second;
      return added ? WEIR_OK : -WEIR_OPTION_VALUE;
    } catch (const std::bad_alloc&) {
      return -WEIR_OUT_OF_MEMORY;
    }
  }
  int remove(const char* name, int unknown) noexcept {
    if (!name) return -unknown;
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(std::string_view(name));
    if (found == entries_.end()) return -unknown;
    entries_.erase(found);
    return WEIR_OK;
  }

  std::optional<Entry> find(std::string_view name) const {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(name);
    return found == entries_.end() ? std::nullopt : std::optional(found->second);
  }
  // "one of: a, b"; "one of: none".
  std::string one_of() const {
    std::lock_guard lock(mutex_);
    std::string names;
    for (const auto& [name, entry] : entries_) names += (names.empty() ? "" : ", ") + name;
    return "one of: " + (names.empty() ? "none" : names);
  }

 private:
  mutable std::mutex mutex_;  // guards entries_
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace weir::infer
