// What operators that are lowered share: refusals, fused activations, windows over pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <string>

#include "lowering/lowered_graph.hpp"

namespace weir::engine {

// MODEL_UNSUPPORTED that says what of the operator is not lowered.
Status refuse(const std::string& why);
// The operator has this many inputs and outputs, and none of them is left out.
Status check_counts(const TfliteGraphOperator& op, size_t inputs_least, size_t inputs_most);

// Numbers of ActivationFunctionType.
enum class Activation : int8_t { kNone = 0, kRelu = 1, kReluN1To1 = 2, kRelu6 = 3 };

// Adds the node that makes tensor `output`, and behind it the limits of a fused activation where
// they cut into the values that its type has. The names of the inputs are given.
Status node_with_activation(LoweredGraph& graph, std::string_view op, std::string_view domain,
                            const std::vector<std::string>& inputs, int32_t output,
                            const OnnxAttributes& attributes, int8_t activation);

// A window that moves over height and width.
struct Window {
  std::array<int64_t, 2> size{}, stride{}, dilation{1, 1};
  bool same = false;  // padding SAME, else VALID

  // Of options whose fields 0 to 2 are padding, stride_w and stride_h.
  static Window of(const FlatTable& options);
  // Top, left, bottom, right, for shapes [batch, height, width, channels]. MODEL_UNSUPPORTED where
  // the output's shape is not what the window gives.
  Result<std::array<int64_t, 4>> pads(const TfliteGraphTensor& input,
                                      const TfliteGraphTensor& output) const;
};

}  // namespace weir::engine
