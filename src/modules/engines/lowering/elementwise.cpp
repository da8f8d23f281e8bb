// Lowers elementwise operators and Softmax.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

// The value, scale and zero point of an 8-bit tensor.
Result<std::vector<std::string>> quantized_value(LoweredGraph& graph, int32_t index) {
  const auto q = graph.quantization(index);
  if (!q) return q.error();
  auto name = graph.value(index);
  if (!name) return name.error();
  return std::vector<std::string>{*std::move(name), graph.scale(q->scale),
                                  graph.zero_point(q->zero_point)};
}

// Uses `quantized` for 8-bit values and `plain` for others.
Status binary(LoweredGraph& graph, const TfliteGraphOperator& op, std::string_view quantized,
              std::string_view plain) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  if (!graph.is_8bit(op.outputs[0])) return plain_binary(graph, op, plain);
  auto inputs = quantized_value(graph, op.inputs[0]);
  if (!inputs) return inputs.error();
  const auto second = quantized_value(graph, op.inputs[1]);
  if (!second) return second.error();
  const auto out = graph.quantization(op.outputs[0]);
  if (!out) return out.error();
  inputs->insert(inputs->end(), second->begin(), second->end());
  inputs->push_back(graph.scale(out->scale));
  inputs->push_back(graph.zero_point(out->zero_point));
  return node_with_activation(graph, quantized, kMicrosoft, *inputs, op.outputs[0], {},
                              op.options.scalar<int8_t>(0, 0));
}

// Quantises floats to the output tensor.
Status quantize(LoweredGraph& graph, const std::string& real, int32_t output) {
  const auto out = quantized_value(graph, output);
  if (!out) return out.error();
  graph.node("QuantizeLinear", "", {real, (*out)[1], (*out)[2]}, (*out)[0]);
  return ok();
}

Result<std::string> dequantized(LoweredGraph& graph, int32_t input) {
  const auto in = quantized_value(graph, input);
  if (!in) return in.error();
  return graph.made("DequantizeLinear", {(*in)[0], (*in)[1], (*in)[2]});
}

}  // namespace

Status lower_add(LoweredGraph& graph, const TfliteGraphOperator& op) {
  return binary(graph, op, "QLinearAdd", "Add");
}

Status lower_multiply(LoweredGraph& graph, const TfliteGraphOperator& op) {
  return binary(graph, op, "QLinearMul", "Mul");
}

Status lower_logistic(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status;
  auto inputs = quantized_value(graph, op.inputs[0]);
  if (!inputs) return inputs.error();
  const auto out = quantized_value(graph, op.outputs[0]);
  if (!out) return out.error();
  inputs->insert(inputs->end(), out->begin() + 1, out->end());
  graph.node("QLinearSigmoid", kMicrosoft, *inputs, (*out)[0]);
  return ok();
}

Status lower_softmax(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status;
  auto real = dequantized(graph, op.inputs[0]);
  if (!real) return real.error();
  if (graph.tensor(op.inputs[0]).shape.empty()) return refuse("a softmax of a single value");
  const auto beta = op.options.scalar<float>(0, 0);
  if (beta != 1) real = graph.made("Mul", {*real, graph.scale(beta)});
  return quantize(graph, graph.made("Softmax", {*real}, OnnxAttributes().number("axis", -1)),
                  op.outputs[0]);
}

Status lower_quantize(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status;
  const bool is_real = graph.tensor(op.inputs[0]).type == TfliteType::kFloat32;
  const auto real = is_real ? graph.value(op.inputs[0]) : dequantized(graph, op.inputs[0]);
  if (!real) return real.error();
  return quantize(graph, *real, op.outputs[0]);
}

Status lower_dequantize(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status;
  const auto in = quantized_value(graph, op.inputs[0]);
  if (!in) return in.error();
  if (graph.tensor(op.outputs[0]).type != TfliteType::kFloat32)
    return refuse("values converted to a type other than float32");
  const auto name = graph.value(op.outputs[0]);
  if (!name) return name.error();
  graph.node("DequantizeLinear", "", *in, *name);
  return ok();
}

}  // namespace weir::engine
