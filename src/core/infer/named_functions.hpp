// NamedFunctions: functions that a program registered in this process, with their data.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/infer/call_gate.hpp"
#include "core/infer/named_objects.hpp"
#include "weir/codes.h"

namespace weir::infer {

// Thread-safe. No function is called while a mutex is held.
template <class Function>
class NamedFunctions {
 public:
  struct Entry {
    Function function;
    void* data;
    std::shared_ptr<CallGate> gate;  // of every call; remove() closes it
  };

  // What the functions of the C ABI return; `unknown` is the code for a name that is not there.
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
  // Afterwards no call of the function runs, except one that this very thread is in, and none
  // begins.
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
