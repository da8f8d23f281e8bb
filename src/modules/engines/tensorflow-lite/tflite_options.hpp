// The options of the TensorFlow Lite engine (specification 4.15).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct TfliteOptions {
  int threads = 0;  // of one invoke; 0 = by the size of the model
  bool xnnpack = true;
  bool resize = false;  // the stream says the inputs' shapes, whatever the file says

  // NumThreads:N (no more than there are cores), Delegate:{XNNPACK,None}, Resize:{true,false}.
  // Other delegates and unknown keys are logged; what cannot be read is OPTION_VALUE.
  static Result<TfliteOptions> read(const weir_open& request);
};

}  // namespace weir::engine
