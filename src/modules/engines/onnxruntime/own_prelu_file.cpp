// Changes the domain of PRelu nodes in an ONNX file (onnx.proto3 of the ONNX project).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <set>

#include "onnxruntime/own_prelu.hpp"
#include "protobuf_reader.hpp"

namespace weir::engine {
namespace {

using Bytes = std::span<const std::byte>;
constexpr uint32_t kExternal = 1;   // TensorProto.DataLocation
constexpr uint32_t kOnnxFloat = 1;  // TensorProto.DataType

void varint(std::vector<std::byte>* out, uint64_t value) {
  for (; value >= 0x80; value >>= 7) out->push_back(std::byte((value & 0x7F) | 0x80));
  out->push_back(std::byte(value));
}
void begin_part(std::vector<std::byte>* out, uint32_t field, size_t size) {
  varint(out, uint64_t{field} << 3 | 2);
  varint(out, size);
}
void part(std::vector<std::byte>* out, uint32_t field, Bytes content) {
  begin_part(out, field, content.size());
  out->insert(out->end(), content.begin(), content.end());
}
Bytes to_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// TensorProto: dims 1, data_type 2, name 8, data_location 14.
struct Constant {
  std::string name;
  uint64_t type = 0, location = 0;
  int long_axes = 0;  // axes longer than 1
  explicit Constant(Bytes tensor) {
    ProtobufReader reader(tensor);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number == 1)
        long_axes += field.delimited ? long_ones(field.bytes) : field.value != 1;
      if (field.number == 2) type = field.value;
      if (field.number == 8) name = field.text();
      if (field.number == 14) location = field.value;
    }
  }
  bool are_slopes() const { return type == kOnnxFloat && long_axes <= 1; }
  // For packed dims: each value ends with a byte below 128.
  static int long_ones(Bytes dims) {
    int count = 0;
    size_t begin = 0;
    for (size_t i = 0; i < dims.size(); ++i) {
      if (static_cast<uint8_t>(dims[i]) >= 0x80) continue;
      if (i > begin || dims[i] != std::byte{1}) ++count;
      begin = i + 1;
    }
    return count;
  }
};

class Graph {
 public:
  explicit Graph(Bytes graph) : graph_(graph) {
    ProtobufReader reader(graph);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number == 5) {
        const Constant one(field.bytes);
        external_ = external_ || one.location == kExternal;
        if (one.are_slopes()) slopes_.insert(one.name);
      }
      // An input with the same name may override a constant.
      if (field.number == 11) inputs_.insert(get_name(field.bytes));
    }
    good_ = reader.good();
  }

  // The graph with renamed nodes; empty when none changes.
  std::vector<std::byte> changed() const {
    std::vector<std::byte> out;
    if (!good_ || external_) return out;
    bool changes = false;
    ProtobufReader reader(graph_);
    out.reserve(graph_.size() + 1024);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (!field.delimited) return {};  // not a field of a graph
      if (field.number == 1 && is_ours(field.bytes)) {
        changes = true;
        std::vector<std::byte> node(field.bytes.begin(), field.bytes.end());
        part(&node, 7, to_bytes("weir"));
        part(&out, 1, node);
      } else {
        part(&out, field.number, field.bytes);
      }
    }
    if (!changes) out.clear();
    return out;
  }

 private:
  static std::string get_name(Bytes value) {
    ProtobufReader reader(value);
    std::string name;
    for (ProtobufReader::Field field; reader.next(&field);)
      if (field.number == 1) name = field.text();
    return name;
  }

  // NodeProto: input 1, op_type 4, domain 7.
  bool is_ours(Bytes node) const {
    ProtobufReader reader(node);
    std::vector<std::string> inputs;
    std::string type, domain;
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number == 1) inputs.emplace_back(field.text());
      if (field.number == 4) type = field.text();
      if (field.number == 7) domain = field.text();
    }
    return type == "PRelu" && (domain.empty() || domain == "ai.onnx") && inputs.size() == 2 &&
           slopes_.contains(inputs[1]) && !inputs_.contains(inputs[1]);
  }

  Bytes graph_;
  std::set<std::string, std::less<>> slopes_, inputs_;
  bool external_ = false, good_ = false;
};

// OperatorSetIdProto: domain 1, version 2. Whether it is ONNX's default domain before version 7,
// when slopes with one axis applied to the channels at any position.
bool has_old_slopes(Bytes operators) {
  ProtobufReader reader(operators);
  std::string domain;
  uint64_t version = 0;
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (field.number == 1) domain = field.text();
    if (field.number == 2) version = field.value;
  }
  return (domain.empty() || domain == "ai.onnx") && version < 7;
}

// Whether a field of the model may stand beside operators of Weir. ModelProto: ir_version 1,
// model_version 5, opset_import 8.
bool can_follow(const ProtobufReader::Field& field) {
  if (!field.delimited) return field.number == 1 || field.number == 5;
  return field.number != 8 || !has_old_slopes(field.bytes);
}

}  // namespace

std::optional<std::vector<std::byte>> with_own_prelu(Bytes file) {
  ProtobufReader reader(file);
  std::vector<std::byte> out;
  bool changes = false;
  for (ProtobufReader::Field field; reader.next(&field);) {
    if (!can_follow(field)) return std::nullopt;
    if (!field.delimited) {
      varint(&out, uint64_t{field.number} << 3);
      varint(&out, field.value);
      continue;
    }
    const auto graph = field.number == 7 ? Graph(field.bytes).changed() : std::vector<std::byte>();
    changes = changes || !graph.empty();
    part(&out, field.number, graph.empty() ? field.bytes : Bytes(graph));
  }
  if (!reader.good() || !changes) return std::nullopt;
  std::vector<std::byte> operators;  // OperatorSetIdProto: domain 1, version 2
  part(&operators, 1, to_bytes("weir"));
  varint(&operators, 2 << 3);
  varint(&operators, 1);
  part(&out, 8, operators);
  return out;
}

}  // namespace weir::engine
