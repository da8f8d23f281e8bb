// Helpers for functions that C code calls: they catch exceptions and log NULL arguments.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <initializer_list>
#include <string>
#include <utility>

#include "weir/result.hpp"

namespace weir::compat {

// Logs a warning with the function's name.
void warn(const char* function, const std::string& text) noexcept;
void warn(const char* function, const Error& error) noexcept;

// Returns false, with a log line, when one of the pointers is NULL.
inline bool given(const char* function, std::initializer_list<const void*> pointers) noexcept {
  for (const void* pointer : pointers)
    if (!pointer) {
      warn(function, "a required argument is NULL");
      return false;
    }
  return true;
}

// Returns the result of `body`, or `fallback`, with a log line, if it throws.
template <class T, class Body>
T or_else(const char* function, T fallback, Body&& body) noexcept {
  try {
    return body();
  } catch (const std::exception& e) {
    warn(function, e.what());
  } catch (...) {
    warn(function, "an unknown exception");
  }
  return fallback;
}
template <class Body>
void attempt(const char* function, Body&& body) noexcept {
  or_else(function, 0, [&] {
    body();
    return 0;
  });
}

}  // namespace weir::compat
