// Results of the C API: ml_error_e numbers, and the text of each thread's last error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <new>
#include <string>

#include "capi-nnstreamer/ml-api-common.h"
#include "weir/result.hpp"

namespace weir::application {

// Stores the text for ml_error() and returns the ml_error_e of the code.
int fail(const Error& error) noexcept;

Error null_pointer(const char* what);

// An error with an explicit ml_error_e, independent of its code.
struct Refusal {
  int number;
  Error error;
};
int fail(const Refusal& refusal) noexcept;
// Uses the ml_error_e of the error's code.
Refusal refusal(const Error& error);

inline int to_ml_error(const Status& status) noexcept {
  return status ? static_cast<int>(ML_ERROR_NONE) : fail(status.error());
}

// Runs `body`, which returns an ml_error_e. Exceptions become errors.
template <class Body>
int guarded(Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return fail(Error{.code = Code::OUT_OF_MEMORY, .what = "memory ran out"});
  } catch (const std::exception& e) {
    return fail(Error{.code = Code::INTERNAL, .what = e.what()});
  } catch (...) {
    return fail(Error{.code = Code::INTERNAL, .what = "an unknown exception"});
  }
}

}  // namespace weir::application
