// What custom= says to the engine Lua.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct LuaOptions {
  std::vector<std::string> libraries;  // that custom= gives the script besides
  bool sandbox = false;                // only the harmless standard libraries
  uint64_t memory_limit = 256;         // MiB of Lua's own memory, for each session

  // OPTION_VALUE for values that cannot be used; a warning in the log for unknown keys.
  static Result<LuaOptions> read(const weir_open& request);
  bool opens(const char* library) const;
};

// What has to be asked for: "io" and so on in a sandbox, "jit" and "ffi" always.
const std::vector<std::string>& withheld_libraries();

}  // namespace weir::engine
