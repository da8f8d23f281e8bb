// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnx_graph.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "protobuf_reader.hpp"

namespace mtcnn::kernels {
namespace {

using weir::engine::ProtobufReader;
using Bytes = std::span<const std::byte>;

std::string get_text(const ProtobufReader::Field& field) {
  return std::string(field.text());
}

// Repeated numbers are packed or separate.
bool append_whole(const ProtobufReader::Field& field, std::vector<int64_t>* out) {
  if (!field.delimited) {
    out->push_back(static_cast<int64_t>(field.value));
    return true;
  }
  Bytes rest = field.bytes;
  while (!rest.empty()) {
    uint64_t value = 0;
    size_t i = 0;
    for (unsigned shift = 0;; shift += 7, ++i) {
      if (i == rest.size() || shift > 63) return false;
      value |= (static_cast<uint64_t>(rest[i]) & 0x7F) << shift;
      if (static_cast<uint8_t>(rest[i]) < 0x80) break;
    }
    out->push_back(static_cast<int64_t>(value));
    rest = rest.subspan(i + 1);
  }
  return true;
}

// Whether so many bytes are the float32 elements of a tensor of this shape.
bool has_size(const std::vector<int64_t>& shape, uint64_t bytes) {
  if (bytes % sizeof(float) != 0) return false;
  uint64_t count = bytes / sizeof(float);
  for (const int64_t extent : shape) {  // divides, because the product can overflow
    if (extent <= 0 || count % static_cast<uint64_t>(extent) != 0) return false;
    count /= static_cast<uint64_t>(extent);
  }
  return count == 1;
}

// TensorProto: dims 1, data_type 2, float_data 4 (packed), name 8, raw_data 9.
bool read_tensor(Bytes bytes, OnnxGraph* out) {
  constexpr uint64_t kFloat = 1;
  ProtobufReader reader(bytes);
  OnnxTensor tensor;
  std::string name;
  uint64_t type = 0;
  Bytes data;
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (field.number == 1 && !append_whole(field, &tensor.shape)) return false;
    if (field.number == 2) type = field.value;
    if (field.number == 8) name = get_text(field);
    if (field.delimited && (field.number == 4 || field.number == 9)) data = field.bytes;
  }
  if (type != kFloat || !reader.good()) return reader.good();
  if (!has_size(tensor.shape, data.size())) return false;
  tensor.numbers.resize(data.size() / sizeof(float));
  std::memcpy(tensor.numbers.data(), data.data(), data.size());
  const bool are_finite = std::all_of(tensor.numbers.begin(), tensor.numbers.end(),
                                      [](float number) { return std::isfinite(number); });
  out->constants[name] = std::move(tensor);
  return are_finite;
}

// AttributeProto: name 1, ints 8. Adds the axes to `order` if it is "perm".
bool read_order(Bytes bytes, std::string* order) {
  ProtobufReader reader(bytes);
  std::string name;
  std::vector<int64_t> axes;
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (field.number == 1) name = get_text(field);
    if (field.number == 8 && !append_whole(field, &axes)) return false;
  }
  if (name == "perm")
    for (const auto axis : axes) *order += std::to_string(axis);
  return reader.good();
}

// NodeProto: input 1, output 2, op_type 4, attribute 5.
bool read_node(Bytes bytes, OnnxGraph* out) {
  ProtobufReader reader(bytes);
  OnnxNode node;
  std::string order;
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (field.number == 1) node.inputs.push_back(get_text(field));
    if (field.number == 2 && node.output.empty()) node.output = get_text(field);
    if (field.number == 4) node.type = get_text(field);
    if (field.number == 5 && field.delimited && !read_order(field.bytes, &order)) return false;
  }
  if (node.type == "Transpose") node.type += "_" + order;
  out->nodes.push_back(std::move(node));
  return reader.good();
}

// GraphProto: node 1, initializer 5.
bool walk_graph(Bytes bytes, OnnxGraph* out) {
  ProtobufReader reader(bytes);
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (field.number == 1 && !read_node(field.bytes, out)) return false;
    if (field.number == 5 && !read_tensor(field.bytes, out)) return false;
  }
  return reader.good();
}

}  // namespace

weir::Result<OnnxGraph> read_graph(std::span<const std::byte> file, const std::string& name) {
  OnnxGraph out;
  ProtobufReader reader(file);  // ModelProto: graph 7
  bool good = true, found = false;
  for (ProtobufReader::Field field; good && reader.next(&field);)
    if (field.number == 7 && field.delimited) {
      found = true;
      good = walk_graph(field.bytes, &out);
    }
  if (good && found && reader.good()) return out;
  return weir::Error{
      .code = weir::Code::MODEL_INVALID,
      .what = "the file of a network is damaged",
      .offered = name + ", " + std::to_string(file.size()) + " bytes",
      .needed = "an ONNX file with all its weights",
      .difference =
          found ? "a node or a tensor ends early, or its data does not match its shape" : "",
      .fix = "examples/mtcnn/fetch"};
}

}  // namespace mtcnn::kernels
