// Lowering: a fully quantised TensorFlow Lite graph as an ONNX graph for ONNX Runtime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::engine {

// Changes whenever the same file would be lowered to other bytes.
inline constexpr int kLoweringVersion = 2;

struct PortQuantization {
  float scale = 0;  // 0: not quantised
  int32_t zero_point = 0;
};
struct LoweredModel {
  std::string onnx;                               // a whole file
  bool cached = false;                            // it was not made now
  std::vector<PortQuantization> inputs, outputs;  // of the model, as the source says
};

struct LoweringSettings {
  bool cache = true;    // on disk (lowering_cache.hpp)
  std::string runtime;  // the version of what will run the graph
};

// The model's own names, types and shapes of inputs and outputs stay. Results differ by rounding:
// docs/guide/lowering.md. MODEL_INVALID for a damaged file; MODEL_UNSUPPORTED, naming the operator,
// for what is not lowered.
Result<LoweredModel> lower_tflite(std::span<const std::byte> file,
                                  const LoweringSettings& settings);

}  // namespace weir::engine
