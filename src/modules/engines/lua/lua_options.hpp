// LuaOptions: the custom= options of the Lua engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct LuaOptions {
  std::vector<std::string> libraries;  // granted by custom= in addition to the defaults
  bool sandbox = false;                // load only the harmless standard libraries
  uint64_t memory_limit = 256;         // MiB of Lua's own memory per session

  // OPTION_VALUE for invalid values; unknown keys log a warning.
  static Result<LuaOptions> read(const weir_open& request);
  bool opens(const char* library) const;
};

// Libraries that must be requested: `jit` and `ffi` always; `io` and others in a sandbox.
const std::vector<std::string>& withheld_libraries();

}  // namespace weir::engine
