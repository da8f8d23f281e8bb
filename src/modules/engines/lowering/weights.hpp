// The weights and biases of a layer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "lowering/lowered_graph.hpp"

namespace weir::engine {

struct Weights {
  std::string data;          // as uint8
  std::vector<float> scale;  // one, or one per channel
  uint8_t zero_point = 0;
  // int8 in the file. XNNPACK runs int8 and rounds once, as QLinear operators do; uint8 is rounded
  // twice (rounding.hpp).
  bool is_signed = false;
};

// In the file's order. `channel_axis`: the axis of length `channels` along which scales may differ.
// MODEL_UNSUPPORTED for anything but a quantised constant.
Result<Weights> read_weights(const LoweredGraph& graph, int32_t index, int32_t channel_axis,
                             int64_t channels);
// The bias in input `at`; zeros when there is none.
Result<std::vector<int32_t>> read_bias(const LoweredGraph& graph, const TfliteGraphOperator& op,
                                       size_t at, int64_t channels);

}  // namespace weir::engine
