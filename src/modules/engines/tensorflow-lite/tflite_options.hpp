// The options of the TensorFlow Lite engine (specification 4.15).
#pragma once
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct TfliteOptions {
  // One by default: with two on a busy machine the median time rose 30-fold (engines.md).
  int threads = 1;
  bool xnnpack = true;
  bool resize = false;  // the stream says the inputs' shapes, whatever the file says

  // NumThreads:N (no more than there are cores), Delegate:{XNNPACK,None}, Resize:{true,false}.
  // Other delegates and unknown keys are logged; what cannot be read is OPTION_VALUE.
  static Result<TfliteOptions> read(const weir_open& request);
};

}  // namespace weir::engine
