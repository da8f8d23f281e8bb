// CError: converts the errors of the C API (weir_error) into those of result.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>

#include "weir/error.h"
#include "weir/result.hpp"

namespace weir {

// Owns a weir_error and converts it to an Error.
class CError {
 public:
  CError() = default;
  CError(const CError&) = delete;
  CError& operator=(const CError&) = delete;
  ~CError() { weir_error_free(error_); }

  weir_error** place() noexcept { return &error_; }
  // Returns the error of a C function that returned `code` (below 0). It has no texts when the C
  // function could not allocate the weir_error.
  Error take(int code) const {
    Error error{.code = static_cast<Code>(-code)};
    error.what = weir_error_what(error_);
    error.offered = weir_error_offered(error_);
    error.needed = weir_error_needed(error_);
    error.difference = weir_error_difference(error_);
    error.fix = weir_error_fix(error_);
    return error;
  }
  // Returns the status of a C function whose return values above 0 have no meaning.
  Status status(int result) const {
    if (result < 0) return take(result);
    return ok();
  }

 private:
  weir_error* error_ = nullptr;
};

}  // namespace weir
