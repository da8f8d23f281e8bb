// TfliteOptions: the options of the TensorFlow Lite engine (docs/compatibility/filter.md 4.15).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct TfliteOptions {
  int threads = 0;              // per invoke; 0 = by the size of the model
  std::optional<bool> xnnpack;  // empty = by the operators of the model
  bool resize = false;          // the stream sets the inputs' shapes, even against the file
  bool resize_rank = false;     // and their ranks

  // NumThreads:N (at most the number of cores), Delegate:{XNNPACK,None}, Resize:{true,false,rank}.
  // Other delegates and unknown keys are logged; OPTION_VALUE for an invalid value.
  static Result<TfliteOptions> read(const weir_open& request);
};

}  // namespace weir::engine
