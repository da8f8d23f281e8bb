// The host's side of the plug-in ABI: the table given to modules, errors that come back, sinks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

// What a weir_error* points to.
struct weir_error {
  weir::Error error;
  bool set = false;
  std::string text = {};  // the whole message, for weir_error_message; empty until it is asked for
};

// What a weir_sink* points to; an element implements it over its output buffer.
struct weir_sink {
  virtual weir::Status set_caps(const std::string& caps) = 0;
  virtual void* reserve(uint64_t bytes) = 0;
  virtual weir::Status share_input(uint32_t index) = 0;

 protected:
  ~weir_sink() = default;
};

namespace weir::infer {

// The table that every module gets; lives until the process ends.
const weir_host& host() noexcept;

// Where modules' log lines go; standard error until set. Called from any thread.
using LogFunction = void (*)(int level, const char* module, const char* text);
void set_log_function(LogFunction function) noexcept;

// The Error behind a negative return; a module that filled none gets `fallback`, and
// CALLBACK_FAILED where the number is no code.
Error take_error(weir_error* error, int result, const std::string& fallback);

}  // namespace weir::infer
