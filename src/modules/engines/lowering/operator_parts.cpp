// Converts fused activations to limits of quantised values; computes padding as TensorFlow does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/operator_parts.hpp"

#include <algorithm>
#include <cmath>

namespace weir::engine {
namespace {

struct Limits {
  uint8_t min = 0, max = 255;
  bool cut() const { return min > 0 || max < 255; }
};

uint8_t quantized(float real, const Quantization& q) {
  const float value = std::round(real / q.scale) + static_cast<float>(q.zero_point);
  return static_cast<uint8_t>(std::clamp(value, 0.0f, 255.0f));
}

Result<Limits> get_limits(int8_t activation, const Quantization& q) {
  switch (static_cast<Activation>(activation)) {
    case Activation::kNone:
      return Limits{};
    case Activation::kRelu:
      return Limits{q.zero_point, 255};
    case Activation::kReluN1To1:
      return Limits{quantized(-1, q), quantized(1, q)};
    case Activation::kRelu6:
      return Limits{q.zero_point, quantized(6, q)};
  }
  return refuse("fused activation number " + std::to_string(activation)).error();
}

}  // namespace

Status refuse(const std::string& why) {
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = "an operator is used in a way that is not lowered",
               .offered = why,
               .fix = "framework=tensorflow-lite without Lowering"};
}

Status check_counts(const TfliteGraphOperator& op, size_t inputs_min, size_t inputs_max) {
  const auto there = [](int32_t index) { return index >= 0; };
  if (op.inputs.size() < inputs_min || op.inputs.size() > inputs_max || op.outputs.size() != 1)
    return refuse(std::to_string(op.inputs.size()) + " inputs and " +
                  std::to_string(op.outputs.size()) + " outputs");
  if (!std::all_of(op.inputs.begin(), op.inputs.begin() + static_cast<int64_t>(inputs_min),
                   there) ||
      op.outputs[0] < 0)
    return refuse("an input or output is missing");
  return ok();
}

Status node_with_activation(LoweredGraph& graph, std::string_view op, std::string_view domain,
                            const std::vector<std::string>& inputs, int32_t output,
                            const OnnxAttributes& attributes, int8_t activation) {
  const auto q = graph.quantization(output);
  if (!q) return q.error();
  const auto name = graph.value(output);
  if (!name) return name.error();
  const auto limits = get_limits(activation, *q);
  if (!limits) return limits.error();
  const std::string computed = limits->cut() ? graph.fresh() : *name;
  graph.node(op, domain, inputs, computed, attributes);
  if (limits->cut())
    graph.node("Clip", "", {computed, graph.zero_point(limits->min), graph.zero_point(limits->max)},
               *name);
  return ok();
}

Window Window::of(const FlatTable& options) {
  Window out;
  out.same = options.scalar<int8_t>(0, 0) == 0;
  out.stride = {options.scalar<int32_t>(2, 0), options.scalar<int32_t>(1, 0)};
  return out;
}

Result<std::array<int64_t, 4>> Window::pads(const TfliteGraphTensor& input,
                                            const TfliteGraphTensor& output) const {
  constexpr int64_t kMax = int64_t{1} << 31;
  if (input.shape.size() != 4 || output.shape.size() != 4 || input.shape[0] != output.shape[0])
    return refuse("shapes that are not [batch, height, width, channels]").error();
  std::array<int64_t, 4> out{};
  for (const size_t axis : {0u, 1u}) {
    const int64_t in = input.shape[axis + 1], made = output.shape[axis + 1];
    if (size[axis] < 1 || stride[axis] < 1 || dilation[axis] < 1 || size[axis] > kMax ||
        dilation[axis] > kMax)
      return refuse("a window of no size or stride").error();
    const int64_t reach = (size[axis] - 1) * dilation[axis] + 1;
    const int64_t room = same ? in : in - reach + 1;
    const int64_t expected = room > 0 ? (room - 1) / stride[axis] + 1 : 0;
    if (expected < 1 || expected != made)
      return refuse("an output of " + std::to_string(made) +
                    " rows or columns where the window "
                    "gives " +
                    std::to_string(expected))
          .error();
    if (!same) continue;
    const int64_t total = std::max<int64_t>((made - 1) * stride[axis] + reach - in, 0);
    out[axis] = total / 2;
    out[axis + 2] = total - total / 2;
  }
  return out;
}

}  // namespace weir::engine
