// OnnxBuilder: builds small ONNX models for tests, field by field (onnx.proto3 of the ONNX
// project).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace weir::engine_test {

// Values of TensorProto.DataType.
enum OnnxType {
  kFloat = 1,
  kUint8 = 2,
  kInt8 = 3,
  kUint16 = 4,
  kInt16 = 5,
  kInt32 = 6,
  kInt64 = 7,
  kString = 8,
  kBool = 9,
  kFloat16 = 10,
  kDouble = 11,
  kUint32 = 12,
  kUint64 = 13,
  kBfloat16 = 16
};

class OnnxBuilder {
 public:
  // Dimensions: a number, or the name of an open one. `shapeless` omits the shape.
  OnnxBuilder& input(const std::string& name, int type, const std::vector<std::string>& shape);
  OnnxBuilder& output(const std::string& name, int type, const std::vector<std::string>& shape);
  OnnxBuilder& shapeless_input(const std::string& name, int type);
  OnnxBuilder& shapeless_output(const std::string& name, int type);
  OnnxBuilder& sequence_output(const std::string& name, int type);
  OnnxBuilder& node(const std::string& op, const std::vector<std::string>& inputs,
                    const std::vector<std::string>& outputs, const std::string& domain = "");
  // Adds an attribute to the last node: one integer or several.
  OnnxBuilder& attribute(const std::string& name, int64_t value);
  OnnxBuilder& attribute(const std::string& name, const std::vector<int64_t>& values);
  OnnxBuilder& constant(const std::string& name, const std::vector<int64_t>& values);
  OnnxBuilder& constant(const std::string& name, const std::vector<int64_t>& shape,
                        const std::vector<float>& values);
  // A constant of floats with its values in a file next to the model.
  OnnxBuilder& constant_in_file(const std::string& name, const std::vector<int64_t>& shape,
                                const std::string& file);
  OnnxBuilder& metadata(const std::string& key, const std::string& value);
  OnnxBuilder& opset(int64_t version) { return opset_ = version, *this; }
  OnnxBuilder& also_uses(const std::string& domain) { return domains_.push_back(domain), *this; }
  std::vector<std::byte> bytes() const;

 private:
  std::vector<std::string> nodes_;
  std::string values_, constants_, metadata_;
  std::vector<std::string> domains_;
  int64_t opset_ = 13;
};

}  // namespace weir::engine_test
