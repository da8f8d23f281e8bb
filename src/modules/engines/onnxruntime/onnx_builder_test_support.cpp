// Writes the protobuf fields of ONNX models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/onnx_builder_test_support.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>

namespace weir::engine_test {
namespace {

std::string varint(uint64_t value) {
  std::string out;
  for (; value >= 0x80; value >>= 7) out += static_cast<char>((value & 0x7F) | 0x80);
  return out + static_cast<char>(value);
}
std::string number(int field, int64_t value) {
  return varint(static_cast<uint64_t>(field) << 3) + varint(static_cast<uint64_t>(value));
}
std::string part(int field, const std::string& content) {
  return varint(static_cast<uint64_t>(field) << 3 | 2) + varint(content.size()) + content;
}

// TypeProto.Tensor: elem_type 1, shape 2 { dim 1 { dim_value 1 or dim_param 2 } }.
std::string tensor_type(int type, const std::vector<std::string>* shape) {
  std::string dims;
  for (const auto& extent : shape ? *shape : std::vector<std::string>{}) {
    const bool digits = std::all_of(extent.begin(), extent.end(),
                                    [](unsigned char c) { return std::isdigit(c) != 0; });
    dims += part(1, digits ? number(1, std::stoll(extent)) : part(2, extent));
  }
  return number(1, type) + (shape ? part(2, dims) : "");
}
std::string value(const std::string& name, const std::string& type) {
  return part(1, name) + part(2, type);
}

}  // namespace

OnnxBuilder& OnnxBuilder::input(const std::string& name, int type,
                                const std::vector<std::string>& shape) {
  values_ += part(11, value(name, part(1, tensor_type(type, &shape))));
  return *this;
}
OnnxBuilder& OnnxBuilder::output(const std::string& name, int type,
                                 const std::vector<std::string>& shape) {
  values_ += part(12, value(name, part(1, tensor_type(type, &shape))));
  return *this;
}
OnnxBuilder& OnnxBuilder::shapeless_output(const std::string& name, int type) {
  values_ += part(12, value(name, part(1, tensor_type(type, nullptr))));
  return *this;
}
OnnxBuilder& OnnxBuilder::shapeless_input(const std::string& name, int type) {
  values_ += part(11, value(name, part(1, tensor_type(type, nullptr))));
  return *this;
}
OnnxBuilder& OnnxBuilder::sequence_output(const std::string& name, int type) {
  const std::string element = part(1, tensor_type(type, nullptr));
  values_ += part(12, value(name, part(4, part(1, element))));
  return *this;
}

OnnxBuilder& OnnxBuilder::node(const std::string& op, const std::vector<std::string>& inputs,
                               const std::vector<std::string>& outputs, const std::string& domain) {
  std::string out;
  for (const auto& name : inputs) out += part(1, name);
  for (const auto& name : outputs) out += part(2, name);
  out += part(4, op);
  if (!domain.empty()) out += part(7, domain);
  nodes_.push_back(out);
  return *this;
}
OnnxBuilder& OnnxBuilder::attribute(const std::string& name, int64_t value) {
  nodes_.back() += part(5, part(1, name) + number(3, value) + number(20, 2));  // type INT
  return *this;
}
OnnxBuilder& OnnxBuilder::attribute(const std::string& name, const std::vector<int64_t>& values) {
  std::string whole = part(1, name) + number(20, 7);  // type INTS
  for (const int64_t value : values) whole += number(8, value);
  nodes_.back() += part(5, whole);
  return *this;
}
OnnxBuilder& OnnxBuilder::constant(const std::string& name, const std::vector<int64_t>& shape,
                                   const std::vector<float>& values) {
  std::string raw(values.size() * sizeof(float), '\0'), whole;
  if (!values.empty()) std::memcpy(raw.data(), values.data(), raw.size());
  for (const int64_t extent : shape) whole += number(1, extent);
  constants_ += part(5, whole + number(2, kFloat) + part(8, name) + part(9, raw));
  return *this;
}
OnnxBuilder& OnnxBuilder::constant(const std::string& name, const std::vector<int64_t>& values) {
  std::string raw(values.size() * sizeof(int64_t), '\0');
  if (!values.empty()) std::memcpy(raw.data(), values.data(), raw.size());
  constants_ += part(5, number(1, static_cast<int64_t>(values.size())) + number(2, kInt64) +
                            part(8, name) + part(9, raw));
  return *this;
}
OnnxBuilder& OnnxBuilder::constant_in_file(const std::string& name,
                                           const std::vector<int64_t>& shape,
                                           const std::string& file) {
  std::string whole;
  for (const int64_t extent : shape) whole += number(1, extent);
  constants_ += part(5, whole + number(2, kFloat) + part(8, name) +
                            part(13, part(1, "location") + part(2, file)) + number(14, 1));
  return *this;
}
OnnxBuilder& OnnxBuilder::metadata(const std::string& key, const std::string& value) {
  metadata_ += part(14, part(1, key) + part(2, value));
  return *this;
}

std::vector<std::byte> OnnxBuilder::bytes() const {
  std::string graph;
  for (const auto& node : nodes_) graph += part(1, node);
  graph += part(2, "test graph") + constants_ + values_;
  std::string model = number(1, 7) + part(2, "weir tests") + part(3, "3.1") + part(7, graph) +
                      part(8, number(2, opset_));
  for (const auto& domain : domains_) model += part(8, part(1, domain) + number(2, 1));
  model += metadata_;
  std::vector<std::byte> out(model.size());
  std::memcpy(out.data(), model.data(), model.size());
  return out;
}

}  // namespace weir::engine_test
