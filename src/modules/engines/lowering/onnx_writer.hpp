// OnnxWriter: writes an ONNX model field by field (onnx.proto3 of the ONNX project).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace weir::engine {

// Values of TensorProto.DataType.
enum class OnnxElement : int32_t {
  kFloat = 1,
  kUint8 = 2,
  kInt8 = 3,
  kInt32 = 6,
  kInt64 = 7,
  kDouble = 11
};

// The attributes of one node.
class OnnxAttributes {
 public:
  OnnxAttributes& number(std::string_view name, int64_t value);
  OnnxAttributes& numbers(std::string_view name, std::span<const int64_t> values);
  OnnxAttributes& text(std::string_view name, std::string_view value);
  const std::string& bytes() const noexcept { return bytes_; }

 private:
  std::string bytes_;
};

class OnnxWriter {
 public:
  void input(std::string_view name, OnnxElement type, std::span<const int64_t> shape);
  void output(std::string_view name, OnnxElement type, std::span<const int64_t> shape);
  // The input "" is omitted; the domain "" is ONNX's own.
  void node(std::string_view op, std::string_view domain, std::span<const std::string> inputs,
            std::string_view output, const OnnxAttributes& attributes = {});
  // `data`: the elements, little-endian.
  void constant(std::string_view name, OnnxElement type, std::span<const int64_t> shape,
                std::string_view data);
  void metadata(std::string_view key, std::string_view value);

  // Returns the complete model.
  std::string model() const;

 private:
  std::string graph_;     // nodes, constants, inputs and outputs, as fields of GraphProto
  std::string metadata_;  // as fields of ModelProto
};

}  // namespace weir::engine
