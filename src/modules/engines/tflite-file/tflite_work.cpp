// Counts multiplications from the shapes of weights and outputs. Operator numbers: BuiltinOperator
// in schema.fbs (version 3) of TensorFlow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/tflite_work.hpp"

#include <optional>

namespace weir::engine {
namespace {

constexpr int32_t kConv2d = 3, kDepthwiseConv2d = 4, kFullyConnected = 9, kTransposeConv = 67;

bool multiplies(int32_t code) {
  return code == kConv2d || code == kDepthwiseConv2d || code == kFullyConnected ||
         code == kTransposeConv;
}
bool is_counted(TfliteType type) {
  return type == TfliteType::kFloat32 || type == TfliteType::kInt8;
}

// Null: there is none.
const TfliteGraphTensor* tensor_at(const TfliteGraph& graph, const std::vector<int32_t>& list,
                                   size_t index) {
  if (index >= list.size() || list[index] < 0) return nullptr;
  const auto at = static_cast<size_t>(list[index]);
  return at < graph.tensors.size() ? &graph.tensors[at] : nullptr;
}

const TfliteGraphTensor* find_weights(const TfliteGraph& graph, const TfliteGraphOperator& node) {
  return tensor_at(graph, node.inputs, 1);
}

// The product of the extents; empty when one is open.
std::optional<double> count_numbers(const TfliteGraphTensor& tensor) {
  double numbers = 1;
  for (const int64_t extent : tensor.shape) {
    if (extent <= 0) return std::nullopt;
    numbers *= static_cast<double>(extent);
  }
  return numbers;
}

// Weights are [out, height, width, in]; for a depthwise convolution [1, height, width, out]; for a
// matrix product [out, in].
double for_each_output(int32_t code, const TfliteGraphTensor& weights, double numbers) {
  const size_t outputs_at = code == kDepthwiseConv2d ? weights.shape.size() - 1 : 0;
  return numbers / static_cast<double>(weights.shape[outputs_at]);
}

}  // namespace

Work tflite_work(const TfliteGraph& graph) {
  Work work;
  for (const auto& node : graph.operators) {
    if (!multiplies(node.code)) continue;
    const auto* weights = find_weights(graph, node);
    const auto* output = tensor_at(graph, node.outputs, 0);
    if (!weights || !output || weights->shape.empty()) continue;
    if (!is_counted(weights->type)) continue;
    const auto read = count_numbers(*weights), made = count_numbers(*output);
    if (!read || !made) continue;
    work.multiplications += *made * for_each_output(node.code, *weights, *read);
    work.weights += *read;
    ++work.operators;
  }
  return work;
}

bool suits_xnnpack(const TfliteGraph& graph) {
  bool has_products = false;
  for (const auto& node : graph.operators) {
    if (!multiplies(node.code)) continue;
    const auto* weights = find_weights(graph, node);
    if (weights && is_counted(weights->type)) return true;
    has_products = true;
  }
  return !has_products;
}

}  // namespace weir::engine
