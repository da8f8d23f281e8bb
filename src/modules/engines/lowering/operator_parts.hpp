// Helpers shared by lowered operators: rejections, fused activations, windows over pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <string>

#include "lowering/lowered_graph.hpp"

namespace weir::engine {

// MODEL_UNSUPPORTED with the reason why the operator is not lowered.
Status refuse(const std::string& why);
// Checks the number of inputs and outputs, and that none is omitted.
Status check_counts(const TfliteGraphOperator& op, size_t inputs_min, size_t inputs_max);

// Values of ActivationFunctionType.
enum class Activation : int8_t { kNone = 0, kRelu = 1, kReluN1To1 = 2, kRelu6 = 3 };

// Adds the node that computes tensor `output`, followed by the limits of a fused activation if they
// restrict the values of its type. `inputs` are value names.
Status node_with_activation(LoweredGraph& graph, std::string_view op, std::string_view domain,
                            const std::vector<std::string>& inputs, int32_t output,
                            const OnnxAttributes& attributes, int8_t activation);

// A window that moves over height and width.
struct Window {
  std::array<int64_t, 2> size{}, stride{}, dilation{1, 1};
  bool same = false;  // SAME padding; false: VALID

  // For options whose fields 0 to 2 are padding, stride_w and stride_h.
  static Window of(const FlatTable& options);
  // Returns top, left, bottom and right for shapes [batch, height, width, channels].
  // MODEL_UNSUPPORTED when the window does not give the output's shape.
  Result<std::array<int64_t, 4>> pads(const TfliteGraphTensor& input,
                                      const TfliteGraphTensor& output) const;
};

}  // namespace weir::engine
