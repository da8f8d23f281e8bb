// At the border to C programs and sub-plugins: nothing is thrown across, a NULL is told.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <initializer_list>
#include <string>
#include <utility>

#include "weir/result.hpp"

namespace weir::compat {

// A line of the log, with the function's name.
void warn(const char* function, const std::string& text) noexcept;
void warn(const char* function, const Error& error) noexcept;

// False, with a line in the log, when one of them is NULL.
inline bool given(const char* function, std::initializer_list<const void*> pointers) noexcept {
  for (const void* pointer : pointers)
    if (!pointer) {
      warn(function, "an argument is NULL that must not be");
      return false;
    }
  return true;
}

// What `body` returns; `fallback`, with a line in the log, for what it throws.
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
