// TfliteBuilder: builds small TensorFlow Lite models for tests (schema.fbs, version 3, of
// TensorFlow).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "tensorflow-lite/flat_writer_test_support.hpp"

namespace weir::engine_test {

// Values of TensorType.
enum TfliteElement : int8_t {
  kTfFloat = 0,
  kTfFloat16 = 1,
  kTfInt32 = 2,
  kTfUint8 = 3,
  kTfInt64 = 4,
  kTfString = 5,
  kTfBool = 6,
  kTfInt16 = 7,
  kTfComplex = 8,
  kTfInt8 = 9,
  kTfDouble = 10,
  kTfUint64 = 12,
  kTfUint32 = 15,
  kTfUint16 = 16
};

// Values of BuiltinOperator.
enum TfliteOperator : int32_t {
  kOpAdd = 0,
  kOpConcatenation = 2,
  kOpDequantize = 6,
  kOpFullyConnected = 9,
  kOpRelu = 19,
  kOpReshape = 22,
  kOpSvdf = 27,
  kOpCustom = 32,
  kOpTranspose = 39,
  kOpSub = 41,
  kOpCast = 53,
  kOpNeg = 59,
  kOpLogicalNot = 87,
  kOpWhere = 109,
  kOpIf = 118
};

struct TfliteQuantization {
  std::vector<float> scale;
  std::vector<int64_t> zero_point;
  int32_t axis = 0;
};

// Tensors are identified by name and numbered in the order in which they are added.
class TfliteBuilder {
 public:
  // -1: the stream sets the dimension; the file's own shape has 1 there.
  TfliteBuilder& input(const std::string& name, int8_t type, const std::vector<int32_t>& shape);
  TfliteBuilder& output(const std::string& name, int8_t type, const std::vector<int32_t>& shape);
  TfliteBuilder& tensor(const std::string& name, int8_t type, const std::vector<int32_t>& shape);
  // A tensor that keeps its value between frames.
  TfliteBuilder& variable(const std::string& name, int8_t type, const std::vector<int32_t>& shape);
  template <class T>
  TfliteBuilder& constant(const std::string& name, int8_t type, const std::vector<int32_t>& shape,
                          const std::vector<T>& values) {
    return add_constant(name, type, shape, FlatValue::vector(to_bytes(values)));
  }
  // Applies to the tensor that was added last.
  TfliteBuilder& quantized(const TfliteQuantization& quantization);
  TfliteBuilder& sparse(const FlatValue& sparsity);
  // The input "" is omitted. A custom operator has a name.
  TfliteBuilder& node(int32_t op, const std::vector<std::string>& inputs,
                      const std::vector<std::string>& outputs, const std::string& custom = "");
  // Sets the BuiltinOptions of the last node: the union member's number and its table.
  TfliteBuilder& options(uint8_t kind, const FlatValue& table);
  TfliteBuilder& description(const std::string& text) { return description_ = text, *this; }
  TfliteBuilder& version(uint32_t number) { return version_ = number, *this; }

  std::vector<std::byte> bytes() const;

 private:
  struct Tensor {
    std::string name;
    int8_t type;
    std::vector<int32_t> shape;
    FlatValue data, quantization, sparsity;
    bool variable = false;
  };
  struct Node {
    int32_t op;
    std::string custom;
    std::vector<std::string> inputs, outputs;
    uint8_t options_kind = 0;
    FlatValue options;
  };
  template <class T>
  static std::vector<uint8_t> to_bytes(const std::vector<T>& values) {
    const auto* first = reinterpret_cast<const uint8_t*>(values.data());
    return {first, first + values.size() * sizeof(T)};
  }
  TfliteBuilder& add_constant(const std::string& name, int8_t type,
                              const std::vector<int32_t>& shape, const FlatValue& data);
  // -1 for "", far out of range for an unknown name.
  std::vector<int32_t> indices(const std::vector<std::string>& names) const;
  FlatValue tensor_table(const Tensor& tensor, uint32_t buffer) const;

  std::vector<Tensor> tensors_;
  std::vector<Node> nodes_;
  std::vector<std::string> inputs_, outputs_;
  std::string description_ = "weir tests";
  uint32_t version_ = 3;
};

// y = -x for float32.
TfliteBuilder tflite_negation(const std::vector<int32_t>& shape = {2, 3});

}  // namespace weir::engine_test
