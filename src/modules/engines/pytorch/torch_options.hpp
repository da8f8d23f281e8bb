// The options of the libtorch engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "declared_tensors.hpp"

namespace weir::engine {

struct TorchOptions {
  int threads = 0;  // per operator; 0 = by the size of the model and its inputs
  bool freeze = true, optimize = true;
  DeclaredTensors declared;

  // NumThreads:N, Freeze:{true,false}, Optimize:{true,false} and the keys of DeclaredTensors.
  // Unknown keys are logged; OPTION_VALUE for an invalid value.
  static Result<TorchOptions> read(const weir_open& request);
};

}  // namespace weir::engine
