// Reads the model's interface from the graph of forward. Only torch_program.cpp includes this.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <torch/csrc/jit/ir/alias_analysis.h>
#include <torch/csrc/jit/ir/constants.h>
#include <torch/csrc/jit/ir/ir.h>

#include <array>
#include <string>

#include "pytorch/torch_program.hpp"
#include "pytorch/torch_tensors.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {

inline Error unsupported_value(const std::string& role, const std::string& type) {
  return unsupported_type("the model's " + role, type,
                          "wrap the model: a module whose forward takes and returns tensors",
                          "Tensor, or a tuple or list of tensors as output");
}

// The number of tensors in a value of this type: 0 for None, empty for a list whose length is set
// at run time. `value` may be null when only the type is known.
inline Result<std::optional<size_t>> count_tensors(const torch::jit::Value* value,
                                                   const c10::TypePtr& type) {
  using Count = std::optional<size_t>;
  if (type->kind() == c10::TypeKind::TensorType) return Count(1);
  if (type->kind() == c10::TypeKind::NoneType) return Count(0);
  const bool tuple = type->kind() == c10::TypeKind::TupleType;
  const bool list = type->kind() == c10::TypeKind::ListType &&
                    type->containedType(0)->kind() == c10::TypeKind::TensorType;
  if (!tuple && !list) return unsupported_value("output", type->annotation_str());
  const auto* node = value ? value->node() : nullptr;
  const bool made_here =
      node && node->kind() == (tuple ? c10::prim::TupleConstruct : c10::prim::ListConstruct);
  if (list && !made_here) return Count();
  size_t sum = 0;
  const size_t parts = made_here ? node->inputs().size() : type->containedTypes().size();
  for (size_t i = 0; i < parts; ++i) {
    const auto* part = made_here ? node->input(i) : nullptr;
    const auto count = count_tensors(part, part ? part->type() : type->containedType(i));
    if (!count || !*count) return count;
    sum += **count;
  }
  return Count(sum);
}

class GraphReader {
 public:
  GraphReader(const torch::jit::Graph& graph, TorchFacts* facts) : graph_(graph), facts_(*facts) {}

  void operators() { visit(graph_.block()); }
  // Input 0 of the graph is the module itself.
  void input(const torch::jit::Value& value) {
    std::string name = value.hasDebugName() ? value.debugName() : "";
    name = name.substr(0, std::min(name.find('.'), name.size()));
    facts_.input_names.push_back(name);
    weir_tensor_info info = open_tensor_info();
    if (const auto tensor = value.type()->cast<c10::TensorType>()) from_type(*tensor, &info);
    for (const auto& use : value.uses())
      if (info.rank == WEIR_RANK_UNKNOWN) from_convolution(*use.user, value, &info);
    facts_.inputs.push_back(info);
  }

 private:
  static void from_type(const c10::TensorType& type, weir_tensor_info* info) {
    if (const auto scalar = type.scalarType())
      info->type = from_torch(*scalar).value_or(uint32_t{WEIR_TYPE_END});
    const auto rank = type.dim();
    if (!rank || *rank > WEIR_RANK_LIMIT) return;
    info->rank = static_cast<uint32_t>(*rank);
    for (size_t i = 0; i < *rank; ++i) info->shape[i] = type.sizes()[i].value_or(-1);
  }
  // Weights [out, in / groups, ...] imply an input [batch, in, ...] of the same type.
  static void from_convolution(const torch::jit::Node& node, const torch::jit::Value& value,
                               weir_tensor_info* info) {
    static constexpr std::array kNames{"aten::conv1d", "aten::conv2d", "aten::conv3d",
                                       "aten::_convolution", "aten::convolution"};
    const std::string name = node.kind().toQualString();
    if (std::find(kNames.begin(), kNames.end(), name) == kNames.end()) return;
    if (node.input(0) != &value) return;
    const auto constant = torch::jit::toIValue(node.input(1));
    if (!constant || !constant->isTensor()) return;
    const auto weights = constant->toTensor();
    const size_t groups_at = name.ends_with("onvolution") ? 8 : 6;
    if (node.inputs().size() <= groups_at || weights.dim() < 3 || weights.dim() > 5) return;
    const auto groups = torch::jit::toIValue(node.input(groups_at));
    const bool transposed =
        groups_at == 8 && torch::jit::toIValue(node.input(6)).value_or(false).toBool();
    const auto type = from_torch(weights.scalar_type());
    if (!groups || !groups->isInt() || transposed || !type) return;
    info->type = *type;
    info->rank = static_cast<uint32_t>(weights.dim());
    std::fill_n(info->shape, info->rank, -1);
    info->shape[1] = weights.size(1) * groups->toInt();
    if (info->rank == 4) info->layout = WEIR_LAYOUT_NCHW;
  }
  // Whether a value of this type may hold a tensor.
  static bool can_hold_tensor(const c10::Type& type) {
    const auto kind = type.kind();
    if (kind == c10::TypeKind::TensorType || kind == c10::TypeKind::AnyType) return true;
    const auto inner = type.containedTypes();
    return std::any_of(inner.begin(), inner.end(),
                       [](const auto& part) { return can_hold_tensor(*part); });
  }
  // Whether forward may append an input to an attribute of this type, at any depth.
  static bool can_keep_tensor(const c10::Type& type) {
    const auto kind = type.kind();
    if (kind == c10::TypeKind::ListType || kind == c10::TypeKind::DictType)
      return can_hold_tensor(type);
    const auto inner = type.containedTypes();
    return std::any_of(inner.begin(), inner.end(),
                       [](const auto& part) { return can_keep_tensor(*part); });
  }
  void visit(const torch::jit::Block* block) {
    static constexpr std::array kByData{
        "aten::nonzero",  "aten::nonzero_numpy", "aten::masked_select",     "aten::_unique",
        "aten::_unique2", "aten::unique_dim",    "aten::unique_consecutive"};
    for (const auto* node : block->nodes()) {
      const std::string name = node->kind().toQualString();
      if (!name.starts_with("prim::")) facts_.operators.insert(name);
      if (name == "prim::SetAttr") facts_.has_state = facts_.keeps_inputs = true;
      if (name == "aten::set_" ||
          (name == "prim::GetAttr" && can_keep_tensor(*node->output()->type())))
        facts_.keeps_inputs = true;
      for (const char* by_data : kByData)
        if (name == by_data || (name == "aten::where" && node->inputs().size() == 1))
          facts_.sizes_depend_on_data = true;
      for (const auto* inner : node->blocks()) visit(inner);
    }
  }

  const torch::jit::Graph& graph_;
  TorchFacts& facts_;
};

// Whether an in-place operator may write to an input or a view of one.
inline bool writes_any_input(const std::shared_ptr<torch::jit::Graph>& graph) {
  const torch::jit::AliasDb aliases(graph, /*isFrozen=*/true);
  for (size_t i = 1; i < graph->inputs().size(); ++i)
    if (aliases.hasWriters(graph->inputs()[i])) return true;
  return false;
}

}  // namespace weir::engine
