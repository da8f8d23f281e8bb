// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/onnx_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "protobuf_reader.hpp"

namespace weir::engine {
namespace {

constexpr int kDepthLimit = 32;  // nesting of graphs
constexpr uint64_t kAxisLimit = uint64_t{1} << 31;

Error invalid(const std::string& offered) {
  return Error{.code = Code::MODEL_INVALID,
               .what = "the file is truncated, damaged or not an ONNX model",
               .offered = offered,
               .needed = "a complete ONNX model",
               .fix = "download or export the model again, then check it with weir inspect MODEL"};
}

Error damage(const ProtobufReader& reader, const char* part) {
  if (reader.missing() > 0)
    return invalid("the " + std::string(part) + " ends at least " +
                   std::to_string(reader.missing()) + " bytes too early");
  return invalid("the " + std::string(part) + " is not a sequence of ONNX fields");
}

// Detects ONNX Runtime's own format, a FlatBuffer.
bool is_ort_format(std::span<const std::byte> head) {
  return head.size() >= 8 && std::memcmp(head.data() + 4, "ORTM", 4) == 0;
}

class Walker {
 public:
  explicit Walker(OnnxSummary* out) : out_(out) {}

  Status model(std::span<const std::byte> bytes) {
    ProtobufReader reader(bytes);
    bool has_graph = false;
    for (ProtobufReader::Field field; reader.next(&field);) {
      Status status = ok();
      if (field.number == 1 && !field.delimited)
        out_->ir_version = static_cast<int64_t>(field.value);
      else if (field.number == 2)
        out_->producer = field.text();
      else if (field.number == 3)
        out_->producer_version = field.text();
      else if (field.number == 7)
        has_graph = true, status = graph(field.bytes, 0);
      else if (field.number == 8)
        status = opset(field.bytes);
      else if (field.number == 25)
        status = function(field.bytes);
      if (!status) return status;
    }
    if (!reader.good()) return damage(reader, "file");
    return has_graph ? ok() : invalid("no graph in the file");
  }

 private:
  Status opset(std::span<const std::byte> bytes) {
    ProtobufReader reader(bytes);
    std::string domain = "ai.onnx";
    int64_t version = 0;
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number == 1 && !field.bytes.empty()) domain = field.text();
      if (field.number == 2) version = static_cast<int64_t>(field.value);
    }
    out_->opsets[domain] = version;
    return reader.good() ? ok() : damage(reader, "operator set");
  }

  Status graph(std::span<const std::byte> bytes, int depth) {
    if (depth > kDepthLimit) return invalid("graphs are nested too deeply");
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);) {
      Status status = ok();
      if (field.number == 1)
        status = node(field.bytes, depth);
      else if (field.number == 5)
        out_->weight_bytes += field.bytes.size(), tensor(field.bytes);
      else if (field.number == 15)
        out_->may_need_other_files = true;  // sparse; none is known
      else if ((field.number == 11 || field.number == 12) && depth == 0)
        status = value(field.bytes, field.number == 11);
      if (!status) return status;
    }
    return reader.good() ? ok() : damage(reader, "graph");
  }

  Status function(std::span<const std::byte> bytes) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);)
      if (field.number == 7)
        if (auto status = node(field.bytes, 1); !status) return status;
    return reader.good() ? ok() : damage(reader, "function");
  }

  Status node(std::span<const std::byte> bytes, int depth) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number == 4) out_->operators.emplace(field.text());
      if (field.number == 5)
        if (auto status = attribute(field.bytes, depth); !status) return status;
    }
    return reader.good() ? ok() : damage(reader, "node");
  }

  Status attribute(std::span<const std::byte> bytes, int depth) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (!field.delimited) continue;
      switch (field.number) {
        case 5:
        case 10:
          out_->constant_bytes += field.bytes.size(), tensor(field.bytes);
          break;
        case 6:
        case 11:
          if (auto status = graph(field.bytes, depth + 1); !status) return status;
          break;
        case 22:
        case 23:
          out_->may_need_other_files = true;  // sparse
          break;
        default:
          break;
      }
    }
    return reader.good() ? ok() : damage(reader, "attribute");
  }

  // TensorProto: external_data 13, data_location 14.
  void tensor(std::span<const std::byte> bytes) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);)
      if (field.number == 13 || (field.number == 14 && field.value != 0))
        out_->may_need_other_files = true;
  }

  // ValueInfoProto: name 1, type 2; TypeProto: tensor_type 1; its shape is field 2.
  Status value(std::span<const std::byte> bytes, bool is_input) {
    ProtobufReader reader(bytes);
    std::string name;
    bool has_shape = false;
    for (ProtobufReader::Field field; reader.next(&field);) {
      if (field.number == 1) name = field.text();
      if (field.number != 2) continue;
      const auto tensor = inner(field.bytes, 1);
      has_shape = contains(tensor, 2);
      if (is_input) count_elements(inner(tensor, 2));
    }
    if (!has_shape) out_->shapeless.insert(name);
    if (!has_shape && is_input) out_->largest_input.reset();
    return reader.good() ? ok() : damage(reader, "description of an input or output");
  }

  // TensorShapeProto: dim 1; its dim_value is field 1.
  void count_elements(std::span<const std::byte> shape) {
    if (!out_->largest_input) return;
    uint64_t elements = 1;
    bool first = true, known = true;
    ProtobufReader reader(shape);
    for (ProtobufReader::Field field; reader.next(&field); first = false) {
      uint64_t size = 0;
      ProtobufReader axis(field.bytes);
      for (ProtobufReader::Field part; axis.next(&part);)
        if (part.number == 1 && !part.delimited) size = part.value;
      const bool has_size = size > 0 && size <= kAxisLimit;
      known = known && (first || has_size);
      elements = std::min(elements * (has_size ? size : 1), kAxisLimit);
    }
    if (known)
      out_->largest_input = std::max(*out_->largest_input, elements);
    else
      out_->largest_input.reset();
  }

  static std::span<const std::byte> inner(std::span<const std::byte> bytes, uint32_t number) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);)
      if (field.number == number && field.delimited) return field.bytes;
    return {};
  }
  static bool contains(std::span<const std::byte> bytes, uint32_t number) {
    ProtobufReader reader(bytes);
    for (ProtobufReader::Field field; reader.next(&field);)
      if (field.number == number) return true;
    return false;
  }

  OnnxSummary* out_;
};

}  // namespace

bool OnnxSummary::shapes_depend_on_data() const {
  static constexpr std::array kOperators{"NonZero", "NonMaxSuppression", "Unique", "Compress",
                                         "StringSplit"};
  return std::any_of(kOperators.begin(), kOperators.end(),
                     [this](const char* name) { return operators.contains(name); });
}

bool OnnxSummary::is_small() const {
  constexpr uint64_t kSmall = 4'000'000'000;  // bytes times elements
  constexpr uint64_t kWithoutWeights = 1000;  // operators that have none take time, too
  if (may_need_other_files || !largest_input) return false;
  return weight_bytes + constant_bytes + kWithoutWeights <
         kSmall / std::max<uint64_t>(*largest_input, 1);
}

int onnx_score(std::span<const unsigned char> head) noexcept {
  if (head.size() >= 8 && std::memcmp(head.data() + 4, "ORTM", 4) == 0) return 100;
  // Field 1, ir_version: 1 to 127 so far; usually followed by a field from 2 (producer) to 8
  // (opset).
  if (head.size() < 3 || head[0] != 0x08 || head[1] == 0 || head[1] > 0x7F) return 0;
  const unsigned number = head[2] >> 3, kind = head[2] & 7;
  const bool plausible = (number == 5 && kind == 0) || (number >= 2 && number <= 8 && kind == 2);
  return plausible ? 90 : 20;
}

Status check_onnx_head(std::span<const std::byte> head) {
  if (is_ort_format(head) || can_begin_message(head)) return ok();
  return invalid("the file is not a sequence of ONNX fields");
}

Result<OnnxSummary> read_onnx(std::span<const std::byte> file) {
  OnnxSummary out;
  out.may_need_other_files = is_ort_format(file);
  if (is_ort_format(file)) return out;
  if (auto status = Walker(&out).model(file); !status) return status.error();
  return out;
}

}  // namespace weir::engine
