// Writes protobuf fields without a library: only a few are needed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/onnx_writer.hpp"

namespace weir::engine {
namespace {

constexpr int64_t kIrVersion = 8, kOpset = 13, kMicrosoftOpset = 1;
// Values of AttributeProto.AttributeType.
constexpr int64_t kInteger = 2, kString = 3, kIntegers = 7;

void varint(std::string* out, uint64_t value) {
  for (; value >= 0x80; value >>= 7) *out += static_cast<char>((value & 0x7F) | 0x80);
  *out += static_cast<char>(value);
}
void number(std::string* out, uint32_t field, int64_t value) {
  varint(out, uint64_t{field} << 3);
  varint(out, static_cast<uint64_t>(value));
}
void part(std::string* out, uint32_t field, std::string_view content) {
  varint(out, uint64_t{field} << 3 | 2);
  varint(out, content.size());
  *out += content;
}

// ValueInfoProto: name 1, type 2; tensor type: elem_type 1, shape 2 { dim 1 { dim_value 1 } }.
std::string value_info(std::string_view name, OnnxElement type, std::span<const int64_t> shape) {
  std::string extents, tensor, kind, out;
  for (const int64_t extent : shape) {
    std::string dimension;
    number(&dimension, 1, extent);
    part(&extents, 1, dimension);
  }
  number(&tensor, 1, static_cast<int64_t>(type));
  part(&tensor, 2, extents);
  part(&kind, 1, tensor);
  part(&out, 1, name);
  part(&out, 2, kind);
  return out;
}

}  // namespace

OnnxAttributes& OnnxAttributes::number(std::string_view name, int64_t value) {
  std::string out;
  part(&out, 1, name);
  engine::number(&out, 3, value);
  engine::number(&out, 20, kInteger);
  part(&bytes_, 5, out);
  return *this;
}

OnnxAttributes& OnnxAttributes::numbers(std::string_view name, std::span<const int64_t> values) {
  std::string out;
  part(&out, 1, name);
  for (const int64_t value : values) engine::number(&out, 8, value);
  engine::number(&out, 20, kIntegers);
  part(&bytes_, 5, out);
  return *this;
}

OnnxAttributes& OnnxAttributes::text(std::string_view name, std::string_view value) {
  std::string out;
  part(&out, 1, name);
  part(&out, 4, value);
  engine::number(&out, 20, kString);
  part(&bytes_, 5, out);
  return *this;
}

void OnnxWriter::input(std::string_view name, OnnxElement type, std::span<const int64_t> shape) {
  part(&graph_, 11, value_info(name, type, shape));
}

void OnnxWriter::output(std::string_view name, OnnxElement type, std::span<const int64_t> shape) {
  part(&graph_, 12, value_info(name, type, shape));
}

void OnnxWriter::node(std::string_view op, std::string_view domain,
                      std::span<const std::string> inputs, std::string_view output,
                      const OnnxAttributes& attributes) {
  std::string out;
  for (const auto& input : inputs) part(&out, 1, input);
  part(&out, 2, output);
  part(&out, 4, op);
  out += attributes.bytes();
  if (!domain.empty()) part(&out, 7, domain);
  part(&graph_, 1, out);
}

void OnnxWriter::constant(std::string_view name, OnnxElement type, std::span<const int64_t> shape,
                          std::string_view data) {
  std::string out;
  for (const int64_t extent : shape) engine::number(&out, 1, extent);
  engine::number(&out, 2, static_cast<int64_t>(type));
  part(&out, 8, name);
  part(&out, 9, data);
  part(&graph_, 5, out);
}

void OnnxWriter::metadata(std::string_view key, std::string_view value) {
  std::string out;
  part(&out, 1, key);
  part(&out, 2, value);
  part(&metadata_, 14, out);
}

std::string OnnxWriter::model() const {
  std::string out, graph = graph_;
  part(&graph, 2, "lowered");
  number(&out, 1, kIrVersion);
  part(&out, 2, "Weir");
  part(&out, 7, graph);
  for (const auto& [domain, version] :
       {std::pair{std::string_view(), kOpset}, {"com.microsoft", kMicrosoftOpset}}) {
    std::string opset;
    if (!domain.empty()) part(&opset, 1, domain);
    number(&opset, 2, version);
    part(&out, 8, opset);
  }
  return out + metadata_;
}

}  // namespace weir::engine
