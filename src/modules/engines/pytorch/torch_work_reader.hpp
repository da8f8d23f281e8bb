// Builds a TorchWork from a frozen graph, whose weights are constants. Only torch_program.cpp
// includes this.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <torch/csrc/jit/ir/constants.h>
#include <torch/csrc/jit/ir/ir.h>

#include <optional>
#include <string_view>
#include <unordered_map>

#include "pytorch/torch_work.hpp"

namespace weir::engine {

class TorchWorkReader {
 public:
  static TorchWork read(const torch::jit::Graph& graph) {
    TorchWorkReader reader;
    // Input 0 of the graph is the module itself.
    for (size_t i = 1; i < graph.inputs().size(); ++i)
      reader.values_[graph.inputs()[i]] = static_cast<uint32_t>(i - 1);
    reader.work_.set_inputs(graph.inputs().empty() ? 0 : graph.inputs().size() - 1);
    reader.visit(graph.block());
    return std::move(reader.work_);
  }

 private:
  using Node = torch::jit::Node;
  using Value = torch::jit::Value;

  static std::optional<at::Tensor> tensor_at(const Node& node, size_t index) {
    if (index >= node.inputs().size()) return std::nullopt;
    const auto constant = torch::jit::toIValue(node.input(index));
    if (!constant || !constant->isTensor() || !constant->toTensor().defined()) return std::nullopt;
    return constant->toTensor();
  }
  // The product of a constant list of integers (a stride, a kernel); 0 for an empty list.
  static double product_at(const Node& node, size_t index, double otherwise = 1) {
    if (index >= node.inputs().size()) return otherwise;
    const auto constant = torch::jit::toIValue(node.input(index));
    if (!constant || !constant->isIntList()) return otherwise;
    const auto list = constant->toIntVector();
    if (list.empty()) return 0;
    double product = 1;
    for (const int64_t value : list) product *= static_cast<double>(std::max<int64_t>(value, 1));
    return product;
  }
  static bool flag_at(const Node& node, size_t index) {
    if (index >= node.inputs().size()) return false;
    const auto constant = torch::jit::toIValue(node.input(index));
    return constant && constant->isBool() && constant->toBool();
  }

  // Weights are [out, in / groups, kernel...]; for a transposed convolution [in, out / groups,
  // ...].
  static void convolution(const Node& node, bool transposed, size_t groups_at,
                          TorchWork::Step* step) {
    const auto weights = tensor_at(node, 1);
    if (!weights || weights->dim() < 3 || weights->numel() == 0) return;
    const auto groups = torch::jit::toIValue(node.input(groups_at));
    const double parts =
        groups && groups->isInt() ? static_cast<double>(std::max<int64_t>(groups->toInt(), 1)) : 1;
    const auto first = static_cast<double>(weights->size(0)),
               second = static_cast<double>(weights->size(1)) * parts;
    const double stride = std::max(product_at(node, 3), 1.0);
    const auto numbers = static_cast<double>(weights->numel());
    step->channels = transposed ? second : first;
    step->growth = transposed ? second / first * stride : first / second / stride;
    step->multiplications = numbers / step->channels / (transposed ? stride : 1);
    step->weights = numbers;
  }
  // `weights` is a matrix [out, in], or [in, out] if `in_first`.
  static void product(const at::Tensor& weights, bool in_first, TorchWork::Step* step) {
    if (weights.dim() != 2 || weights.numel() == 0) return;
    const auto in = static_cast<double>(weights.size(in_first ? 0 : 1)),
               out = static_cast<double>(weights.size(in_first ? 1 : 0));
    step->growth = out / in;
    step->channels = out;
    step->multiplications = in;
    step->weights = in * out;
  }
  static void read_operator(const Node& node, TorchWork::Step* step) {
    const std::string_view name = node.kind().toQualString();
    if (name == "aten::conv1d" || name == "aten::conv2d" || name == "aten::conv3d") {
      convolution(node, false, 6, step);
    } else if ((name == "aten::_convolution" || name == "aten::convolution") &&
               node.inputs().size() > 8) {
      convolution(node, flag_at(node, 6), 8, step);
    } else if (name.starts_with("aten::conv_transpose") && node.inputs().size() > 6) {
      convolution(node, true, 6, step);
    } else if (name == "aten::linear" || name == "aten::matmul" || name == "aten::mm") {
      if (const auto weights = tensor_at(node, 1)) product(*weights, name != "aten::linear", step);
    } else if (name == "aten::addmm") {
      if (const auto weights = tensor_at(node, 2)) product(*weights, true, step);
    } else if (name.starts_with("aten::max_pool") || name.starts_with("aten::avg_pool")) {
      const double stride = product_at(node, 2);
      step->growth = 1 / std::max(stride > 0 ? stride : product_at(node, 1), 1.0);
    } else if (name.starts_with("aten::adaptive_")) {
      step->positions = std::max(product_at(node, 1), 1.0);
    } else if (name == "aten::mean" && node.inputs().size() > 1 && product_at(node, 1, 0) > 0) {
      step->positions = 1;
    } else if (name == "prim::ListConstruct") {  // of tensors: the argument of aten::cat
      step->joins = true;
    } else if (name == "prim::ListUnpack") {  // from aten::chunk and aten::split
      step->growth = 1.0 / static_cast<double>(node.outputs().size());
    }
  }

  // False for integers, such as sizes, which are not tensors.
  static bool has_tensors(const Value& value) {
    const auto& type = value.type();
    return type->kind() == c10::TypeKind::TensorType ||
           (type->kind() == c10::TypeKind::ListType &&
            type->containedType(0)->kind() == c10::TypeKind::TensorType);
  }
  void visit(const torch::jit::Block* block) {
    for (const Node* node : block->nodes()) {
      for (const auto* inner : node->blocks()) visit(inner);
      if (node->outputs().empty() || !has_tensors(*node->outputs()[0])) continue;
      TorchWork::Step step;
      read_operator(*node, &step);
      const auto take = [&](const Value* value) {
        const auto found = values_.find(value);
        if (found != values_.end()) step.from.push_back(found->second);
      };
      for (const auto* input : node->inputs()) take(input);
      for (const auto* inner : node->blocks())
        for (const auto* output : inner->outputs()) take(output);
      if (step.from.empty()) continue;  // only constants as inputs
      const uint32_t made = work_.add(std::move(step));
      for (const auto* output : node->outputs()) values_[output] = made;
    }
  }

  TorchWork work_;
  std::unordered_map<const Value*, uint32_t> values_;
};

}  // namespace weir::engine
