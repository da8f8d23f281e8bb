// Lowers operators that gather values by index, stack tensors along a new axis, or unstack them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

bool same_stored(const LoweredGraph& graph, int32_t a, int32_t b) {
  const auto &x = graph.tensor(a), &y = graph.tensor(b);
  return x.type == y.type;
}

bool are_places(const LoweredGraph& graph, int32_t index) {
  const auto type = graph.tensor(index).type;
  return type == TfliteType::kInt32 || type == TfliteType::kInt64;
}

// Constant indices must be within the axis; computed indices are not known here.
Status check_places(const LoweredGraph& graph, int32_t index, const std::vector<int64_t>& extents) {
  if (!are_places(graph, index)) return refuse("indices that are not int32 or int64");
  if (graph.tensor(index).data.empty()) return ok();
  const auto places = graph.integers(index);
  if (!places) return places.error();
  for (size_t i = 0; i < places->size(); ++i)
    if ((*places)[i] < 0 || (*places)[i] >= extents[i % extents.size()])
      return refuse("an index outside the tensor: " + std::to_string((*places)[i]));
  return ok();
}

}  // namespace

Status lower_gather(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  const auto& shape = graph.tensor(op.inputs[0]).shape;
  const auto rank = static_cast<int32_t>(shape.size());
  auto axis = op.options.scalar<int32_t>(0, 0);
  if (axis < 0) axis += rank;
  if (axis < 0 || axis >= rank) return refuse("an axis that does not exist");
  if (op.options.scalar<int32_t>(1, 0) != 0) return refuse("indices for each part of a batch");
  if (!same_stored(graph, op.inputs[0], op.outputs[0]))
    return refuse("an output whose type differs from the input's");
  if (auto status = check_places(graph, op.inputs[1], {shape[static_cast<size_t>(axis)]}); !status)
    return status;
  const auto in = graph.value(op.inputs[0]), at = graph.value(op.inputs[1]),
             out = graph.value(op.outputs[0]);
  for (const auto* each : {&in, &at, &out})
    if (!*each) return each->error();
  graph.node("Gather", "", {*in, *at}, *out, OnnxAttributes().number("axis", axis));
  return ok();
}

Status lower_gather_nd(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  const auto &shape = graph.tensor(op.inputs[0]).shape, &places = graph.tensor(op.inputs[1]).shape;
  if (places.empty() || places.back() < 1 || places.back() > static_cast<int64_t>(shape.size()))
    return refuse("indices with more axes than the tensor has");
  if (!same_stored(graph, op.inputs[0], op.outputs[0]))
    return refuse("an output whose type differs from the input's");
  const std::vector<int64_t> extents(shape.begin(), shape.begin() + places.back());
  if (auto status = check_places(graph, op.inputs[1], extents); !status) return status;
  const auto in = graph.value(op.inputs[0]), at = graph.value(op.inputs[1]),
             out = graph.value(op.outputs[0]);
  for (const auto* each : {&in, &at, &out})
    if (!*each) return each->error();
  const auto wide = graph.made(
      "Cast", {*at}, OnnxAttributes().number("to", static_cast<int64_t>(OnnxElement::kInt64)));
  graph.node("GatherND", "", {*in, wide}, *out);
  return ok();
}

Status lower_pack(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1024); !status) return status;
  auto shape = graph.tensor(op.outputs[0]).shape;
  const auto rank = static_cast<int32_t>(shape.size());
  auto axis = op.options.scalar<int32_t>(1, 0);
  if (axis < 0) axis += rank;
  if (axis < 0 || axis >= rank) return refuse("an axis that does not exist");
  shape[static_cast<size_t>(axis)] = 1;
  std::vector<std::string> parts;
  for (const int32_t input : op.inputs) {
    if (input < 0) return refuse("an input is missing");
    if (!same_stored(graph, input, op.outputs[0]) ||
        graph.tensor(input).scale != graph.tensor(op.outputs[0]).scale ||
        graph.tensor(input).zero_point != graph.tensor(op.outputs[0]).zero_point)
      return refuse("an input whose type or scale differs from the output's");
    const auto name = graph.value(input);
    if (!name) return name.error();
    parts.push_back(graph.made("Reshape", {*name, graph.shape(shape)}));
  }
  const auto out = graph.value(op.outputs[0]);
  if (!out) return out.error();
  graph.node("Concat", "", parts, *out, OnnxAttributes().number("axis", axis));
  return ok();
}

Status lower_unpack(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (op.inputs.size() != 1 || op.inputs[0] < 0) return refuse("not exactly one input");
  const auto& shape = graph.tensor(op.inputs[0]).shape;
  const auto rank = static_cast<int32_t>(shape.size());
  auto axis = op.options.scalar<int32_t>(1, 0);
  if (axis < 0) axis += rank;
  if (axis < 0 || axis >= rank) return refuse("an axis that does not exist");
  if (static_cast<int64_t>(op.outputs.size()) != shape[static_cast<size_t>(axis)])
    return refuse("a number of outputs that differs from the length of the axis");
  const auto in = graph.value(op.inputs[0]);
  if (!in) return in.error();
  for (size_t i = 0; i < op.outputs.size(); ++i) {
    const int32_t output = op.outputs[i];
    if (output < 0) return refuse("an output is missing");
    if (!same_stored(graph, op.inputs[0], output))
      return refuse("an output whose type differs from the input's");
    const auto out = graph.value(output);
    if (!out) return out.error();
    graph.node("Gather", "", {*in, graph.place(static_cast<int64_t>(i))}, *out,
               OnnxAttributes().number("axis", axis));
  }
  return ok();
}

}  // namespace weir::engine
