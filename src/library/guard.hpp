// The boundary of the C API: converts errors to objects and stops exceptions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <new>
#include <string>

#include "weir/error.h"
#include "weir/result.hpp"

namespace weir::library {

// Stores `error` at `place` unless that is null; returns -code. Stores NULL when out of memory.
inline int keep(weir_error** place, const Error& error) noexcept {
  const int code = static_cast<int>(error.code);
  if (place)
    *place = weir_error_new(code, error.what.c_str(), error.offered.c_str(), error.needed.c_str(),
                            error.difference.c_str(), error.fix.c_str());
  return -code;
}

inline Error null_pointer(const char* what) {
  return Error{.code = Code::OPTION_VALUE, .what = std::string(what) + " is a null pointer"};
}

// Runs `body`, which returns a value of the C API. Clears the place first.
template <class Body>
int guarded(weir_error** place, Body&& body) noexcept {
  if (place) *place = nullptr;
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return keep(place, Error{.code = Code::OUT_OF_MEMORY, .what = "memory ran out"});
  } catch (const std::exception& e) {
    return keep(place, Error{.code = Code::INTERNAL, .what = e.what()});
  } catch (...) {
    return keep(place, Error{.code = Code::INTERNAL, .what = "an unknown exception"});
  }
}

}  // namespace weir::library
