// At the border to C: errors become objects, nothing is thrown across.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <new>
#include <string>

#include "weir/error.h"
#include "weir/result.hpp"

namespace weir::library {

// Keeps `error` for the caller where there is a place; returns -code. When memory ran out for that
// too, the place gets NULL.
inline int keep(weir_error** place, const Error& error) noexcept {
  const int code = static_cast<int>(error.code);
  if (place)
    *place = weir_error_new(code, error.what.c_str(), error.offered.c_str(), error.needed.c_str(),
                            error.difference.c_str(), error.fix.c_str());
  return -code;
}

inline Error null_pointer(const char* what) {
  return Error{Code::OPTION_VALUE, std::string(what) + " is a null pointer", "", "", "", ""};
}

// Runs `body`, which returns what a function of the C face returns. The place is cleared first.
template <class Body>
int guarded(weir_error** place, Body&& body) noexcept {
  if (place) *place = nullptr;
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return keep(place, Error{Code::OUT_OF_MEMORY, "memory ran out", "", "", "", ""});
  } catch (const std::exception& e) {
    return keep(place, Error{Code::INTERNAL, e.what(), "", "", "", ""});
  } catch (...) {
    return keep(place, Error{Code::INTERNAL, "an unknown exception", "", "", "", ""});
  }
}

}  // namespace weir::library
