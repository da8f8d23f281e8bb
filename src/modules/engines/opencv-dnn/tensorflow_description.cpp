// Parses a frozen TensorFlow graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "opencv-dnn/dnn_description.hpp"
#include "protobuf_reader.hpp"

namespace weir::engine {
namespace {

using Field = ProtobufReader::Field;

Error invalid_graph(const std::string& offered) {
  return Error{.code = Code::MODEL_INVALID,
               .what = "the file is truncated, damaged or not a frozen TensorFlow graph",
               .offered = offered,
               .needed = "a complete GraphDef (.pb) whose variables are constants",
               .fix = "download or freeze the graph again"};
}

Error invalid_graph(const ProtobufReader& reader, const std::string& part) {
  return invalid_graph(reader.missing() > 0
                           ? "the " + part + " ends at least " + std::to_string(reader.missing()) +
                                 " bytes too early"
                           : "the " + part + " is not a sequence of fields");
}

struct Node {
  std::string name, op;
  std::vector<std::string> inputs;
  uint64_t type = 0;  // type of a placeholder
  std::optional<std::vector<int64_t>> shape;
  std::string data_format;
};

// types.proto: DT_FLOAT and up.
std::optional<uint32_t> type_of_number(uint64_t number) {
  static constexpr std::pair<uint64_t, uint32_t> kTypes[]{
      {1, WEIR_FLOAT32},  {2, WEIR_FLOAT64}, {3, WEIR_INT32}, {4, WEIR_UINT8},
      {5, WEIR_INT16},    {6, WEIR_INT8},    {9, WEIR_INT64}, {17, WEIR_UINT16},
      {19, WEIR_FLOAT16}, {10, WEIR_UINT8}};
  for (const auto& [of_tensorflow, weir] : kTypes)
    if (number == of_tensorflow) return weir;
  return std::nullopt;
}

// Dim: size 1; -1: not known.
Result<int64_t> read_extent(std::span<const std::byte> bytes, const std::string& node) {
  int64_t extent = 0;
  ProtobufReader reader(bytes);
  for (Field field; reader.next(&field);)
    if (field.number == 1) extent = static_cast<int64_t>(field.value);
  if (!reader.good()) return invalid_graph(reader, "shape of " + node);
  return std::max<int64_t>(extent, -1);
}

// TensorShapeProto: dim 2, unknown_rank 3.
Status read_shape(std::span<const std::byte> bytes, Node* out) {
  std::vector<int64_t> shape;
  ProtobufReader reader(bytes);
  bool unknown = false;
  for (Field field; reader.next(&field);) {
    if (field.number == 3 && field.value != 0) unknown = true;
    if (field.number != 2) continue;
    const auto extent = read_extent(field.bytes, out->name);
    if (!extent) return extent.error();
    shape.push_back(*extent);
  }
  if (!reader.good()) return invalid_graph(reader, "shape of " + out->name);
  if (!unknown && shape.size() <= WEIR_RANK_LIMIT) out->shape = std::move(shape);
  return ok();
}

// AttrValue: s 2, type 6, shape 7.
Status read_value(std::span<const std::byte> bytes, const std::string& key, Node* out) {
  ProtobufReader reader(bytes);
  for (Field field; reader.next(&field);) {
    if (key == "dtype" && field.number == 6) out->type = field.value;
    if (key == "data_format" && field.number == 2) out->data_format = field.text();
    if (key == "shape" && field.number == 7 && out->op.starts_with("Placeholder"))
      if (auto status = read_shape(field.bytes, out); !status) return status;
  }
  return reader.good() ? ok() : invalid_graph(reader, "attribute " + key + " of " + out->name);
}

// A map entry: key 1, value 2.
Status read_attribute(std::span<const std::byte> bytes, Node* out) {
  ProtobufReader reader(bytes);
  std::string key;
  for (Field field; reader.next(&field);) {
    if (field.number == 1) key = field.text();
    if (field.number == 2)
      if (auto status = read_value(field.bytes, key, out); !status) return status;
  }
  return reader.good() ? ok() : invalid_graph(reader, "attribute of " + out->name);
}

// NodeDef: name 1, op 2, input 3, attr 5.
Result<Node> read_node(std::span<const std::byte> bytes) {
  Node out;
  ProtobufReader names(bytes);
  for (Field field; names.next(&field);) {
    if (field.number == 1) out.name = field.text();
    if (field.number == 2) out.op = field.text();
    if (field.number == 3) out.inputs.emplace_back(field.text());
  }
  if (!names.good()) return invalid_graph(names, "node " + out.name);
  ProtobufReader reader(bytes);
  for (Field field; reader.next(&field);)
    if (field.number == 5)
      if (auto status = read_attribute(field.bytes, &out); !status) return status.error();
  return out;
}

bool is_one_of(const std::string& op, std::span<const char* const> list) {
  return std::any_of(list.begin(), list.end(), [&op](const char* other) { return op == other; });
}

constexpr std::array kSpatial{"Conv2D",         "DepthwiseConv2dNative", "MaxPool",
                              "AvgPool",        "FusedBatchNorm",        "FusedBatchNormV3",
                              "ResizeBilinear", "ResizeNearestNeighbor", "Conv2DBackpropInput"};
// Operators whose output has the layout of their input.
constexpr std::array kAsTheirInput{
    "BiasAdd", "Relu", "Relu6", "LeakyRelu", "Elu",     "Sigmoid", "Tanh", "Identity", "Add",
    "AddV2",   "Sub",  "Mul",   "Maximum",   "Minimum", "RealDiv", "Pad",  "ConcatV2", "Softmax"};

// Freezing writes nodes in execution order.
void mark_pictures(const std::vector<Node>& nodes, DnnDescription* out) {
  const auto plain = [](const std::string& input) { return input.substr(0, input.find(':')); };
  for (const auto& node : nodes) {
    const bool spatial = is_one_of(node.op, kSpatial) && node.data_format != "NCHW";
    out->nhwc = out->nhwc || spatial;
    bool follows = false;
    if (is_one_of(node.op, kAsTheirInput))
      for (const auto& input : node.inputs)
        follows = follows || out->pictures.contains(plain(input));
    if (spatial || follows) out->pictures.insert(node.name);
    if ((node.op == "BiasAdd" || node.op == "Identity") && !node.inputs.empty())
      out->passed[node.name] = plain(node.inputs[0]);
  }
}

Result<DeclaredTensor> make_input(const Node& node) {
  const auto type = type_of_number(node.type);
  if (!type)
    return Error{
        .code = Code::MODEL_UNSUPPORTED,
        .what = "the model's input " + node.name + " has a type that streams do not support",
        .offered = "elements of TensorFlow's type number " + std::to_string(node.type) +
                   (node.type == 7 ? " (string)" : ""),
        .needed = "numbers",
        .fix = "freeze the graph after that input"};
  DeclaredTensor input{node.name, *type, node.shape && !node.shape->empty(), {}};
  if (node.shape) input.shape = *node.shape;
  return input;
}

}  // namespace

Result<DnnDescription> describe_tensorflow(std::span<const std::byte> graph) {
  DnnDescription out;
  std::vector<Node> nodes;
  ProtobufReader reader(graph);
  for (Field field; reader.next(&field);) {
    if (field.number != 1) continue;
    if (!field.delimited) return invalid_graph("an invalid_graph node");
    auto node = read_node(field.bytes);
    if (!node) return node.error();
    nodes.push_back(*std::move(node));
  }
  if (!reader.good()) return invalid_graph(reader, "file");
  if (nodes.empty()) return invalid_graph("the graph has no node");
  for (const auto& node : nodes) {
    out.nodes.insert(node.name);
    out.operators.insert(node.op);
    if (!node.op.starts_with("Placeholder")) continue;
    auto input = make_input(node);
    if (!input) return input.error();
    out.inputs.push_back(*std::move(input));
  }
  mark_pictures(nodes, &out);
  return out;
}

}  // namespace weir::engine
