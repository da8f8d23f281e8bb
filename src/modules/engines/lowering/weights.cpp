// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/weights.hpp"

#include <algorithm>
#include <cstring>

#include "lowering/operator_parts.hpp"

namespace weir::engine {

// `channel_axis`: the axis of length `channels` along which scales may differ.
Result<Weights> read_weights(const LoweredGraph& graph, int32_t index, int32_t channel_axis,
                             int64_t channels) {
  const auto& tensor = graph.tensor(index);
  if (!graph.is_8bit(index) || tensor.data.empty() || tensor.scale.empty())
    return refuse("weights that are not quantised constants").error();
  const auto count = static_cast<int64_t>(tensor.scale.size());
  if (count > 1 && (count != channels || tensor.axis != channel_axis))
    return refuse("weights with scales along another axis").error();
  const bool is_signed = tensor.type == TfliteType::kInt8;
  const int64_t given = tensor.zero_point.empty() ? 0 : tensor.zero_point[0];
  const int64_t moved = is_signed ? 128 : 0;  // offset from int8 to uint8
  if (std::any_of(tensor.zero_point.begin(), tensor.zero_point.end(),
                  [&](int64_t z) { return z != given; }) ||
      given < -moved || given > 255 - moved)
    return refuse("zero points of weights that differ or are out of range").error();
  if (!std::all_of(tensor.scale.begin(), tensor.scale.end(), [](float s) { return s > 0; }))
    return refuse("a scale of weights that is 0").error();
  Weights out{{}, tensor.scale, static_cast<uint8_t>(given + moved), is_signed};
  if (is_signed)
    out.data = moved_up(tensor.data);
  else
    out.data.assign(reinterpret_cast<const char*>(tensor.data.data()), tensor.data.size());
  return out;
}

// Zeros without a bias.
Result<std::vector<int32_t>> read_bias(const LoweredGraph& graph, const TfliteGraphOperator& op,
                                       size_t at, int64_t channels) {
  std::vector<int32_t> out(static_cast<size_t>(channels));
  if (op.inputs.size() <= at || op.inputs[at] < 0) return out;
  const auto& tensor = graph.tensor(op.inputs[at]);
  if (tensor.type != TfliteType::kInt32 || tensor.data.size() != 4 * out.size())
    return refuse("a bias that is not a constant of int32 for each channel").error();
  std::memcpy(out.data(), tensor.data.data(), tensor.data.size());
  return out;
}

}  // namespace weir::engine
