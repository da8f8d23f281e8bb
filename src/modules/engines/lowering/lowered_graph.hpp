// LoweredGraph: the ONNX graph that is being made of a TensorFlow Lite graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lowering/onnx_writer.hpp"
#include "tflite-file/tflite_graph.hpp"
#include "weir/result.hpp"

namespace weir::engine {

inline constexpr const char* kMicrosoft = "com.microsoft";  // ONNX Runtime's own operators

// real = scale * (value - zero_point), of values from 0 to 255.
struct Quantization {
  float scale = 0;
  uint8_t zero_point = 0;
  bool operator==(const Quantization&) const = default;
};

// Every 8-bit tensor is uint8 inside: int8 values are moved up by 128 with their zero point, which
// changes nothing but the letters of the type. Kernels for uint8 by uint8 never saturate, whatever
// the processor; those for uint8 by int8 do where it lacks VNNI. Dimensions stay in the order of
// TensorFlow Lite, colours last.
class LoweredGraph {
 public:
  explicit LoweredGraph(const TfliteGraph& graph);

  // Inputs and outputs of the model; MODEL_UNSUPPORTED for what cannot be one.
  Status begin();
  Status end();
  // The whole ONNX model.
  std::string model() const { return writer_.model(); }

  const TfliteGraphTensor& tensor(int32_t index) const {
    return source_.tensors[static_cast<size_t>(index)];
  }
  bool is_8bit(int32_t index) const;
  // MODEL_UNSUPPORTED where the tensor is not an 8-bit one with one scale.
  Result<Quantization> quantization(int32_t index) const;
  // The name of its value; a constant is written on first use. MODEL_UNSUPPORTED for types that
  // are not lowered.
  Result<std::string> value(int32_t index);
  // Elements of a constant of int32 or int64; MODEL_UNSUPPORTED where it is none.
  Result<std::vector<int64_t>> integers(int32_t index) const;

  // Names of constants.
  std::string scale(float value) { return scales({&value, 1}); }
  std::string scales(std::span<const float> values);  // a scalar for one value
  std::string zero_point(uint8_t value);
  std::string shape(std::span<const int64_t> values);
  std::string place(int64_t value);   // a scalar of int64
  std::string number(int32_t value);  // a scalar
  std::string real(double value);     // a scalar of double precision
  std::string bytes(std::span<const int64_t> shape, std::string_view values);  // of uint8
  std::string words(std::span<const int64_t> shape, std::string_view values);  // of int32
  std::string floats(std::span<const int64_t> shape, std::span<const float> values);

  std::string fresh() { return "#" + std::to_string(count_++); }
  void node(std::string_view op, std::string_view domain, std::initializer_list<std::string> inputs,
            const std::string& output, const OnnxAttributes& attributes = {}) {
    writer_.node(op, domain, std::vector<std::string>(inputs), output, attributes);
  }
  void node(std::string_view op, std::string_view domain, const std::vector<std::string>& inputs,
            const std::string& output, const OnnxAttributes& attributes = {}) {
    writer_.node(op, domain, inputs, output, attributes);
  }
  // One node, whose output is a new name.
  std::string made(std::string_view op, std::initializer_list<std::string> inputs,
                   const OnnxAttributes& attributes = {}) {
    std::string name = fresh();
    node(op, "", inputs, name, attributes);
    return name;
  }

 private:
  std::string port_name(int32_t index);
  void write_port(bool input, int32_t index, const std::string& name);
  std::string constant(OnnxElement type, std::span<const int64_t> shape, std::string_view data);

  const TfliteGraph& source_;
  OnnxWriter writer_;
  std::map<int32_t, std::string> names_;                  // of values, by tensor
  std::vector<std::pair<int32_t, std::string>> leaving_;  // int8 outputs, and what they are called
  std::set<std::string> port_names_;
  std::map<std::string, std::string> constants_;  // by type, shape and bytes
  uint64_t count_ = 0;
};

// An int8 as the uint8 that stands for it, and so its zero point.
std::string moved_up(std::span<const std::byte> values);

}  // namespace weir::engine
