// Assembles the tables of a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_builder_test_support.hpp"

#include <algorithm>

namespace weir::engine_test {

TfliteBuilder& TfliteBuilder::tensor(const std::string& name, int8_t type,
                                     const std::vector<int32_t>& shape) {
  tensors_.push_back({name, type, shape, {}, {}, {}, false});
  return *this;
}
TfliteBuilder& TfliteBuilder::input(const std::string& name, int8_t type,
                                    const std::vector<int32_t>& shape) {
  inputs_.push_back(name);
  return tensor(name, type, shape);
}
TfliteBuilder& TfliteBuilder::output(const std::string& name, int8_t type,
                                     const std::vector<int32_t>& shape) {
  outputs_.push_back(name);
  return tensor(name, type, shape);
}
TfliteBuilder& TfliteBuilder::variable(const std::string& name, int8_t type,
                                       const std::vector<int32_t>& shape) {
  tensor(name, type, shape);
  tensors_.back().variable = true;
  return *this;
}
TfliteBuilder& TfliteBuilder::add_constant(const std::string& name, int8_t type,
                                           const std::vector<int32_t>& shape,
                                           const FlatValue& data) {
  tensor(name, type, shape);
  tensors_.back().data = data;
  return *this;
}

TfliteBuilder& TfliteBuilder::quantized(const TfliteQuantization& quantization) {
  tensors_.back().quantization = FlatValue::table({{2, FlatValue::vector(quantization.scale)},
                                                   {3, FlatValue::vector(quantization.zero_point)},
                                                   {6, FlatValue::scalar(quantization.axis)}});
  return *this;
}
TfliteBuilder& TfliteBuilder::sparse(const FlatValue& sparsity) {
  tensors_.back().sparsity = sparsity;
  return *this;
}

TfliteBuilder& TfliteBuilder::node(int32_t op, const std::vector<std::string>& inputs,
                                   const std::vector<std::string>& outputs,
                                   const std::string& custom) {
  nodes_.push_back({op, custom, inputs, outputs, 0, {}});
  return *this;
}
TfliteBuilder& TfliteBuilder::options(uint8_t kind, const FlatValue& table) {
  nodes_.back().options_kind = kind;
  nodes_.back().options = table;
  return *this;
}

std::vector<int32_t> TfliteBuilder::indices(const std::vector<std::string>& names) const {
  std::vector<int32_t> out;
  for (const auto& name : names) {
    const auto found = std::find_if(tensors_.begin(), tensors_.end(),
                                    [&](const Tensor& tensor) { return tensor.name == name; });
    out.push_back(name.empty()              ? -1
                  : found == tensors_.end() ? 1'000'000
                                            : static_cast<int32_t>(found - tensors_.begin()));
  }
  return out;
}

FlatValue TfliteBuilder::tensor_table(const Tensor& tensor, uint32_t buffer) const {
  auto shape = tensor.shape;
  const bool open = std::find(shape.begin(), shape.end(), -1) != shape.end();
  std::replace(shape.begin(), shape.end(), -1, 1);
  return FlatValue::table({{0, FlatValue::vector(shape)},
                           {1, FlatValue::scalar(tensor.type)},
                           {2, FlatValue::scalar(buffer)},
                           {3, FlatValue::text(tensor.name)},
                           {4, tensor.quantization},
                           {5, tensor.variable ? FlatValue::scalar(uint8_t{1}) : FlatValue()},
                           {6, tensor.sparsity},
                           {7, open ? FlatValue::vector(tensor.shape) : FlatValue()}});
}

std::vector<std::byte> TfliteBuilder::bytes() const {
  std::vector<FlatValue> codes, nodes, tensors, buffers{FlatValue::table({})};
  for (const auto& tensor : tensors_) {
    tensors.push_back(
        tensor_table(tensor, tensor.data.is_absent() ? 0 : static_cast<uint32_t>(buffers.size())));
    if (!tensor.data.is_absent()) buffers.push_back(FlatValue::table({{0, tensor.data}}));
  }
  for (const auto& node : nodes_) {
    nodes.push_back(FlatValue::table(
        {{0, FlatValue::scalar(static_cast<uint32_t>(codes.size()))},
         {1, FlatValue::vector(indices(node.inputs))},
         {2, FlatValue::vector(indices(node.outputs))},
         {3, node.options_kind ? FlatValue::scalar(node.options_kind) : FlatValue()},
         {4, node.options}}));
    codes.push_back(
        FlatValue::table({{0, FlatValue::scalar(static_cast<int8_t>(std::min(node.op, 127)))},
                          {1, node.custom.empty() ? FlatValue() : FlatValue::text(node.custom)},
                          {3, FlatValue::scalar(node.op)}}));
  }
  const auto graph = FlatValue::table({{0, FlatValue::tables(tensors)},
                                       {1, FlatValue::vector(indices(inputs_))},
                                       {2, FlatValue::vector(indices(outputs_))},
                                       {3, FlatValue::tables(nodes)},
                                       {4, FlatValue::text("main")}});
  return FlatValue::table({{0, FlatValue::scalar(version_)},
                           {1, FlatValue::tables(codes)},
                           {2, FlatValue::tables({graph})},
                           {3, FlatValue::text(description_)},
                           {4, FlatValue::tables(buffers)}})
      .file("TFL3");
}

TfliteBuilder tflite_negation(const std::vector<int32_t>& shape) {
  return TfliteBuilder()
      .input("x", kTfFloat, shape)
      .output("y", kTfFloat, shape)
      .node(kOpNeg, {"x"}, {"y"});
}

}  // namespace weir::engine_test
