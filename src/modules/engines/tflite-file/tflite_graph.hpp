// TfliteGraph: the first graph of a TensorFlow Lite file, its tensors and operators.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tflite-file/flat_buffer.hpp"
#include "weir/result.hpp"

namespace weir::engine {

// Numbers of TensorType.
enum class TfliteType : uint8_t { kFloat32 = 0, kInt32 = 2, kUint8 = 3, kInt64 = 4, kInt8 = 9 };

struct TfliteGraphTensor {
  std::string name;
  TfliteType type{};  // others than the above may come
  std::vector<int64_t> shape;
  // real = scale * (value - zero_point): one for the tensor, or one for each index of `axis`.
  std::vector<float> scale;
  std::vector<int64_t> zero_point;
  int32_t axis = 0;
  bool variable = false;
  std::span<const std::byte> data;  // within the file; empty: not a constant
};

struct TfliteGraphOperator {
  int32_t code = 0;                      // BuiltinOperator
  std::string custom;                    // its name, of custom operators
  std::vector<int32_t> inputs, outputs;  // -1: left out
  FlatTable options;                     // BuiltinOptions
};

struct TfliteGraph {
  std::unique_ptr<FlatFile> file;  // what the options point to
  std::vector<TfliteGraphTensor> tensors;
  std::vector<TfliteGraphOperator> operators;  // in the order they run
  std::vector<int32_t> inputs, outputs;
};

// `bytes` must outlive the graph. MODEL_INVALID as read_tflite says.
Result<TfliteGraph> read_tflite_graph(std::span<const std::byte> bytes);

}  // namespace weir::engine
