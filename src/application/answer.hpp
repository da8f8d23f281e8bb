// Answers of the C face: errors become numbers, and their words the thread's last error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <new>
#include <string>

#include "capi-nnstreamer/ml-tensors.h"
#include "weir/result.hpp"

namespace weir::application {

// Keeps the words for ml_error(); returns the ml_error_e of the code.
int fail(const Error& error) noexcept;

Error null_pointer(const char* what);

// An error that has an ml_error_e of its own, whatever its code.
struct Refusal {
  int number;
  Error error;
};
int fail(const Refusal& refusal) noexcept;
// With the ml_error_e of its code.
Refusal refusal(const Error& error);

inline int answer(const Status& status) noexcept {
  return status ? static_cast<int>(ML_ERROR_NONE) : fail(status.error());
}

// Runs `body`, which returns an ml_error_e: nothing is thrown across.
template <class Body>
int guarded(Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return fail(Error{Code::OUT_OF_MEMORY, "memory ran out", "", "", "", ""});
  } catch (const std::exception& e) {
    return fail(Error{Code::INTERNAL, e.what(), "", "", "", ""});
  } catch (...) {
    return fail(Error{Code::INTERNAL, "an unknown exception", "", "", "", ""});
  }
}

}  // namespace weir::application
