// LoweredGraph: builds an ONNX graph from a TensorFlow Lite graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "lowering/onnx_writer.hpp"
#include "tflite-file/tflite_graph.hpp"
#include "weir/result.hpp"

namespace weir::engine {

inline constexpr const char* kMicrosoft = "com.microsoft";  // ONNX Runtime's own operators

// real = scale * (value - zero_point), for values from 0 to 255.
struct Quantization {
  float scale = 0;
  uint8_t zero_point = 0;
  bool operator==(const Quantization&) const = default;
};

// Every 8-bit tensor is uint8 internally: int8 values and their zero point are increased by 128,
// which keeps their real values. Kernels for uint8 by uint8 never saturate on any processor; those
// for uint8 by int8 do on processors without VNNI. Dimensions stay in TensorFlow Lite's order,
// channels last.
class LoweredGraph {
 public:
  explicit LoweredGraph(const TfliteGraph& graph);

  // Adds the model's inputs and outputs; MODEL_UNSUPPORTED for unsuitable ones.
  Status begin();
  Status end();
  // Returns the complete ONNX model.
  std::string model() const { return writer_.model(); }

  const TfliteGraphTensor& tensor(int32_t index) const {
    return source_.tensors[static_cast<size_t>(index)];
  }
  bool is_8bit(int32_t index) const;
  // MODEL_UNSUPPORTED unless the tensor is 8-bit with a single scale.
  Result<Quantization> quantization(int32_t index) const;
  // Returns the name of the tensor's value; the first use of a constant writes it.
  // MODEL_UNSUPPORTED for types that are not lowered.
  Result<std::string> value(int32_t index);
  // The elements of an int32 or int64 constant; MODEL_UNSUPPORTED for other tensors.
  Result<std::vector<int64_t>> integers(int32_t index) const;

  // Constants; these return the constant's name.
  std::string scale(float value) { return scales({&value, 1}); }
  std::string scales(std::span<const float> values);  // a scalar for one value
  std::string zero_point(uint8_t value);
  std::string shape(std::span<const int64_t> values);
  std::string place(int64_t value);                                            // an int64 scalar
  std::string number(int32_t value);                                           // an int32 scalar
  std::string real(double value);                                              // a double scalar
  std::string bytes(std::span<const int64_t> shape, std::string_view values);  // uint8
  std::string int32_constant(std::span<const int64_t> shape, std::string_view values);  // int32
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
  // Adds one node and returns the name of its output, which is new.
  std::string made(std::string_view op, std::initializer_list<std::string> inputs,
                   const OnnxAttributes& attributes = {}) {
    std::string name = fresh();
    node(op, "", inputs, name, attributes);
    return name;
  }

 private:
  Status check_port(int32_t index) const;
  void begin_input(int32_t index);
  std::string port_name(int32_t index);
  void write_port(bool input, int32_t index, const std::string& name);
  std::string constant(OnnxElement type, std::span<const int64_t> shape, std::string_view data);

  const TfliteGraph& source_;
  OnnxWriter writer_;
  std::map<int32_t, std::string> names_;                  // of values, by tensor
  std::vector<std::pair<int32_t, std::string>> leaving_;  // int8 outputs and their names
  std::set<std::string> port_names_;
  std::map<std::string, std::string> constants_;  // by type, shape and bytes
  uint64_t count_ = 0;
};

// Converts int8 values, or an int8 zero point, to uint8.
std::string moved_up(std::span<const std::byte> values);

}  // namespace weir::engine
