// store_option(): stores the value of an option, or returns the error with which reading it failed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>

#include "weir/result.hpp"

namespace weir::engine {

template <class T>
Status store_option(Result<T> value, T* out) {
  if (!value) return value.error();
  *out = *std::move(value);
  return ok();
}

}  // namespace weir::engine
