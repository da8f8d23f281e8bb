// Chooses the engine for a .tflite model: TensorFlow Lite or, at the user's request, ONNX Runtime
// with the lowered graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::engine {

// Returns `own`, wrapped: a model opened with Lowering:onnxruntime is lowered and opened by ONNX
// Runtime, which is logged. A model that cannot be lowered stays with `own`, with a warning that
// names the operator. `own` must exist until the process exits.
weir_engine choosing_table(const weir_engine& own);

}  // namespace weir::engine
