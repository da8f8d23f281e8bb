// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowered_graph.hpp"

#include <cstring>
#include <span>

namespace weir::engine {
namespace {

constexpr const char* kSupportedQuantization = "int8 or uint8 with one scale";
constexpr int64_t kMoved = 128;  // offset from int8 to uint8
constexpr size_t kSmall = 256;   // bytes; equal constants up to this size are shared

Error not_lowered(const std::string& what, const std::string& offered, const std::string& needed) {
  return {.code = Code::MODEL_UNSUPPORTED,
          .what = what,
          .offered = offered,
          .needed = needed,
          .fix = "framework=tensorflow-lite without Lowering"};
}

std::string tensor_text(const TfliteGraphTensor& tensor) {
  return "tensor " + tensor.name + ", element type " + std::to_string(int(tensor.type));
}

std::optional<OnnxElement> to_onnx_element(TfliteType type) {
  switch (type) {
    case TfliteType::kFloat32:
      return OnnxElement::kFloat;
    case TfliteType::kInt32:
      return OnnxElement::kInt32;
    case TfliteType::kInt64:
      return OnnxElement::kInt64;
    case TfliteType::kUint8:
      return OnnxElement::kUint8;
    case TfliteType::kInt8:
      return OnnxElement::kInt8;
  }
  return std::nullopt;
}

std::string_view chars(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Protobuf strings must be valid UTF-8; names are limited to plain ASCII.
bool is_plain(std::string_view text) {
  for (const char c : text)
    if (c < ' ' || c > '~') return false;
  return !text.empty() && text[0] != '#';
}

}  // namespace

std::string moved_up(std::span<const std::byte> values) {
  std::string out(chars(values));
  for (char& value : out) value = static_cast<char>(value ^ '\x80');
  return out;
}

LoweredGraph::LoweredGraph(const TfliteGraph& graph) : source_(graph) {}

bool LoweredGraph::is_8bit(int32_t index) const {
  const auto type = tensor(index).type;
  return type == TfliteType::kUint8 || type == TfliteType::kInt8;
}

Result<Quantization> LoweredGraph::quantization(int32_t index) const {
  const auto& found = tensor(index);
  const bool fits = is_8bit(index) && found.scale.size() == 1 && found.scale[0] > 0;
  if (!fits)
    return not_lowered("a tensor is not quantised", tensor_text(found), kSupportedQuantization);
  int64_t zero = found.zero_point.empty() ? 0 : found.zero_point[0];
  if (zero < -kMoved || zero > 255)
    return not_lowered("a zero point is out of range", std::to_string(zero), "0 to 255");
  if (found.type == TfliteType::kInt8) zero += kMoved;
  if (zero < 0 || zero > 255)
    return not_lowered("a zero point is out of range", std::to_string(zero), "0 to 255");
  return Quantization{found.scale[0], static_cast<uint8_t>(zero)};
}

std::string LoweredGraph::port_name(int32_t index) {
  const std::string& name = tensor(index).name;
  if (is_plain(name) && port_names_.insert(name).second) return name;
  return "#port" + std::to_string(index);
}

void LoweredGraph::write_port(bool input, int32_t index, const std::string& name) {
  const auto& port = tensor(index);
  const auto type = *to_onnx_element(port.type);
  if (input)
    writer_.input(name, type, port.shape);
  else
    writer_.output(name, type, port.shape);
}

Status LoweredGraph::check_port(int32_t index) const {
  if (!to_onnx_element(tensor(index).type))
    return not_lowered("an input or output of the model is of a type that is not lowered",
                       tensor_text(tensor(index)), "8-bit, int32, int64 or float32");
  if (tensor(index).type == TfliteType::kInt8)
    if (auto known = quantization(index); !known) return known.error();
  return ok();
}

void LoweredGraph::begin_input(int32_t index) {
  const std::string name = port_name(index);
  write_port(true, index, name);
  names_[index] = name;
  if (tensor(index).type != TfliteType::kInt8) return;
  const auto q = *quantization(index);
  const auto zero = static_cast<char>(q.zero_point ^ 0x80);
  const auto given = constant(OnnxElement::kInt8, {}, {&zero, 1});
  names_[index] = made("QuantizeLinear", {made("DequantizeLinear", {name, scale(q.scale), given}),
                                          scale(q.scale), zero_point(q.zero_point)});
}

Status LoweredGraph::begin() {
  for (const auto* side : {&source_.inputs, &source_.outputs})
    for (const int32_t index : *side)
      if (auto status = check_port(index); !status) return status;
  for (const int32_t index : source_.inputs) begin_input(index);
  for (const int32_t index : source_.outputs) {
    if (names_.contains(index) || !tensor(index).data.empty() || tensor(index).variable)
      return not_lowered("an output of the graph is an input, a constant or another output",
                         tensor_text(tensor(index)), "an output that an operator makes");
    const std::string name = port_name(index);
    if (tensor(index).type == TfliteType::kInt8)
      leaving_.emplace_back(index, name), names_[index] = fresh();
    else
      names_[index] = name;
  }
  return ok();
}

Status LoweredGraph::end() {
  for (const auto& [index, name] : leaving_) {
    const auto q = *quantization(index);
    const auto zero = static_cast<char>(q.zero_point ^ 0x80);
    const auto wanted = constant(OnnxElement::kInt8, {}, {&zero, 1});
    const auto real =
        made("DequantizeLinear", {names_[index], scale(q.scale), zero_point(q.zero_point)});
    node("QuantizeLinear", "", {real, scale(q.scale), wanted}, name);
  }
  for (const int32_t index : source_.outputs) {
    std::string name = names_[index];
    for (const auto& [output, outside] : leaving_)
      if (output == index) name = outside;
    write_port(false, index, name);
  }
  return ok();
}

Result<std::string> LoweredGraph::value(int32_t index) {
  if (const auto known = names_.find(index); known != names_.end()) return known->second;
  const auto& found = tensor(index);
  const auto type = to_onnx_element(found.type);
  if (!type || found.variable)
    return not_lowered("a tensor is of a type that is not lowered", tensor_text(found),
                       "8-bit, int32, int64 or float32");
  std::string name;
  if (found.data.empty())
    name = fresh();
  else if (*type == OnnxElement::kInt8)
    name = bytes(found.shape, moved_up(found.data));
  else
    name = constant(*type, found.shape, chars(found.data));
  names_[index] = name;
  return name;
}

Result<std::vector<int64_t>> LoweredGraph::integers(int32_t index) const {
  const auto& found = tensor(index);
  const size_t each = found.type == TfliteType::kInt32   ? 4
                      : found.type == TfliteType::kInt64 ? 8
                                                         : 0;
  if (each == 0 || found.data.empty())
    return not_lowered("a shape or axis is not a constant", tensor_text(found),
                       "a constant of int32 or int64");
  std::vector<int64_t> out(found.data.size() / each);
  for (size_t i = 0; i < out.size(); ++i) {
    int32_t narrow = 0;
    if (each == 4) {
      std::memcpy(&narrow, found.data.data() + i * each, each);
      out[i] = narrow;
    } else {
      std::memcpy(&out[i], found.data.data() + i * each, each);
    }
  }
  return out;
}

std::string LoweredGraph::constant(OnnxElement type, std::span<const int64_t> shape,
                                   std::string_view data) {
  std::string key;
  if (data.size() <= kSmall) {
    key = std::to_string(int(type)) + ':';
    for (const int64_t extent : shape) key += std::to_string(extent) + ',';
    key += ':';
    key += data;
    if (const auto known = constants_.find(key); known != constants_.end()) return known->second;
  }
  std::string name = fresh();
  writer_.constant(name, type, shape, data);
  if (!key.empty()) constants_[key] = name;
  return name;
}

std::string LoweredGraph::scales(std::span<const float> values) {
  const auto count = static_cast<int64_t>(values.size());
  return floats(std::span(&count, count == 1 ? 0 : 1), values);
}
std::string LoweredGraph::zero_point(uint8_t value) {
  const auto letter = static_cast<char>(value);
  return constant(OnnxElement::kUint8, {}, {&letter, 1});
}
std::string LoweredGraph::shape(std::span<const int64_t> values) {
  const auto count = static_cast<int64_t>(values.size());
  return constant(OnnxElement::kInt64, {&count, 1}, chars(std::as_bytes(values)));
}
std::string LoweredGraph::place(int64_t value) {
  return constant(OnnxElement::kInt64, {}, chars(std::as_bytes(std::span(&value, 1))));
}
std::string LoweredGraph::number(int32_t value) {
  return constant(OnnxElement::kInt32, {}, chars(std::as_bytes(std::span(&value, 1))));
}
std::string LoweredGraph::real(double value) {
  return constant(OnnxElement::kDouble, {}, chars(std::as_bytes(std::span(&value, 1))));
}
std::string LoweredGraph::bytes(std::span<const int64_t> shape, std::string_view values) {
  return constant(OnnxElement::kUint8, shape, values);
}
std::string LoweredGraph::int32_constant(std::span<const int64_t> shape, std::string_view values) {
  return constant(OnnxElement::kInt32, shape, values);
}
std::string LoweredGraph::floats(std::span<const int64_t> shape, std::span<const float> values) {
  return constant(OnnxElement::kFloat, shape, chars(std::as_bytes(values)));
}

}  // namespace weir::engine
