// Who runs a .tflite model: TensorFlow Lite, or, where the user chose so, another engine that gets
// the lowered graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::engine {

// The table of the engine: `own`, but a model opened with Lowering:onnxruntime is lowered and given
// to ONNX Runtime, with a line in the log; what is not lowered stays with `own`, with a warning
// that names the operator. `own` must live as long as the process.
weir_engine choosing_table(const weir_engine& own);

}  // namespace weir::engine
