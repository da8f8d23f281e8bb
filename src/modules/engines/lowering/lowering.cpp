// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowering.hpp"

#include "lowering/lowered_graph.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

std::string operator_name(const TfliteGraphOperator& op) {
  if (!op.custom.empty()) return op.custom;
  const auto* known = known_operator(op.code);
  return known ? known->name : "with the number " + std::to_string(op.code);
}

Status lower_operator(LoweredGraph* graph, const TfliteGraphOperator& op, size_t place) {
  const std::string where =
      "the operator " + operator_name(op) + " (number " + std::to_string(place + 1) + ")";
  const auto* known = op.custom.empty() ? known_operator(op.code) : nullptr;
  if (!known || !known->lower)
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = where + " is not lowered to ONNX Runtime",
                 .fix = "framework=tensorflow-lite without Lowering"};
  Status status = known->lower(*graph, op);
  if (status) return status;
  Error error = status.error();
  error.offered = error.what + (error.offered.empty() ? "" : ": ") + error.offered;
  error.what = where + " is not lowered to ONNX Runtime";
  return error;
}

std::vector<PortQuantization> ports(const TfliteGraph& graph, const std::vector<int32_t>& indices) {
  std::vector<PortQuantization> out;
  for (const int32_t index : indices) {
    const auto& tensor = graph.tensors[static_cast<size_t>(index)];
    PortQuantization port;
    if (tensor.scale.size() == 1) {
      port.scale = tensor.scale[0];
      port.zero_point = tensor.zero_point.empty() ? 0 : static_cast<int32_t>(tensor.zero_point[0]);
    }
    out.push_back(port);
  }
  return out;
}

Result<std::string> lower_graph(const TfliteGraph& source) {
  LoweredGraph graph(source);
  if (auto status = graph.begin(); !status) return status.error();
  for (size_t i = 0; i < source.operators.size(); ++i)
    if (auto status = lower_operator(&graph, source.operators[i], i); !status)
      return status.error();
  if (auto status = graph.end(); !status) return status.error();
  return graph.model();
}

}  // namespace

Result<LoweredModel> lower_tflite(std::span<const std::byte> file) {
  const auto source = read_tflite_graph(file);
  if (!source) return source.error();
  auto graph = lower_graph(*source);
  if (!graph) return graph.error();
  return LoweredModel{*std::move(graph), ports(*source, source->inputs),
                      ports(*source, source->outputs)};
}

}  // namespace weir::engine
