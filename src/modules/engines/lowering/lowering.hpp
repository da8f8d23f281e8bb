// Lowering: converts a fully quantised TensorFlow Lite graph to an ONNX graph for ONNX Runtime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::engine {

struct PortQuantization {
  float scale = 0;  // 0: not quantised
  int32_t zero_point = 0;
};
struct LoweredModel {
  std::string onnx;                               // a complete file
  std::vector<PortQuantization> inputs, outputs;  // of the model, as in the source
};

// Keeps the names, types and shapes of the model's inputs and outputs. Results differ by rounding:
// docs/guide/lowering.md. MODEL_INVALID for a damaged file; MODEL_UNSUPPORTED, naming the operator,
// for what cannot be lowered.
Result<LoweredModel> lower_tflite(std::span<const std::byte> file);

}  // namespace weir::engine
