// NamedFunctions: functions that a program registered in this process, with their data.
#pragma once
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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
  };

  // What the functions of the C ABI return; `unknown` is the code for a name that is not there.
  int add(const char* name, Function function, void* data) noexcept {
    if (!name || !*name || !function) return -WEIR_OPTION_VALUE;
    try {
      return entries_.add(name, Entry{function, data}) ? WEIR_OK : -WEIR_OPTION_VALUE;
    } catch (const std::bad_alloc&) {
      return -WEIR_OUT_OF_MEMORY;
    }
  }
  int remove(const char* name, int unknown) noexcept {
    return name && entries_.remove(name) ? WEIR_OK : -unknown;
  }
  std::optional<Entry> find(std::string_view name) const { return entries_.find(name); }
  std::string one_of() const { return entries_.one_of(); }
  std::vector<std::string> names() const { return entries_.names(); }

 private:
  NamedObjects<Entry> entries_;
};

}  // namespace weir::infer
