// NamedFunctions: functions that the application registered, with their data.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/infer/module/named_objects.hpp"
#include "core/infer/queue/call_gate.hpp"
#include "weir/codes.h"

namespace weir::infer {

// Thread-safe. No mutex is held while a function is called.
template <class Function>
class NamedFunctions {
 public:
  struct Entry {
    Function function;
    void* data;
    std::shared_ptr<CallGate> gate;  // passed by every call; remove() closes it
  };

  // Return values of the C ABI; `unknown` is the code for an unregistered name.
  int add(const char* name, Function function, void* data) noexcept {
    if (!name || !*name || !function) return -WEIR_OPTION_VALUE;
    try {
      return entries_.add(name, Entry{function, data, std::make_shared<CallGate>()})
                 ? WEIR_OK
                 : -WEIR_OPTION_VALUE;
    } catch (const std::bad_alloc&) {
      return -WEIR_OUT_OF_MEMORY;
    }
  }
  // Once it has returned, the function is not running, except in this very thread, and is not
  // called again.
  int remove(const char* name, int unknown) noexcept {
    const auto removed = name ? entries_.remove(name) : std::nullopt;
    if (!removed) return -unknown;
    removed->gate->close();
    return WEIR_OK;
  }
  std::optional<Entry> find(std::string_view name) const { return entries_.find(name); }
  std::string one_of() const { return entries_.one_of(); }
  std::vector<std::string> names() const { return entries_.names(); }

 private:
  NamedObjects<Entry> entries_;
};

}  // namespace weir::infer
