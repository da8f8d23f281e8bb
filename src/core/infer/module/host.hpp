// The host side of the plug-in ABI: the table for modules, returned errors, sinks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

// The implementation of weir_error.
struct weir_error {
  weir::Error error;
  bool set = false;
  std::string text = {};  // message() for weir_error_message, created on first use
};

// The implementation of weir_sink; an element derives from it for its output buffer.
struct weir_sink {
  virtual weir::Status set_caps(const std::string& caps) = 0;
  virtual void* reserve(uint64_t bytes) = 0;
  virtual weir::Status share_input(uint32_t index) = 0;

 protected:
  ~weir_sink() = default;
};

namespace weir::infer {

// The table for every module; valid until the process ends.
const weir_host& host() noexcept;

// Receives log lines of modules, on any thread; the default is standard error.
using LogFunction = void (*)(int level, const char* module, const char* text);
void set_log_function(LogFunction function) noexcept;

// Converts a negative return value and its weir_error; `fallback` replaces a missing text, and
// CALLBACK_FAILED a number that is not a code.
Error take_error(weir_error* error, int result, const std::string& fallback);

}  // namespace weir::infer
