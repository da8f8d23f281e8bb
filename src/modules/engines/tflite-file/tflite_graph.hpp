// TfliteGraph: the first graph of a TensorFlow Lite file, with its tensors and operators.
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

// Values of TensorType.
enum class TfliteType : uint8_t { kFloat32 = 0, kInt32 = 2, kUint8 = 3, kInt64 = 4, kInt8 = 9 };

struct TfliteGraphTensor {
  std::string name;
  TfliteType type{};  // may be a value not listed above
  std::vector<int64_t> shape;
  // real = scale * (value - zero_point): one value per tensor, or one per index of `axis`.
  std::vector<float> scale;
  std::vector<int64_t> zero_point;
  int32_t axis = 0;
  bool variable = false;
  std::span<const std::byte> data;  // within the file; empty when not a constant
};

struct TfliteGraphOperator {
  int32_t code = 0;                      // BuiltinOperator
  std::string custom;                    // name of a custom operator
  std::vector<int32_t> inputs, outputs;  // -1: omitted
  FlatTable options;                     // BuiltinOptions
};

struct TfliteGraph {
  std::unique_ptr<FlatFile> file;  // options point into it
  std::vector<TfliteGraphTensor> tensors;
  std::vector<TfliteGraphOperator> operators;  // in execution order
  std::vector<int32_t> inputs, outputs;
};

// `bytes` must outlive the graph. MODEL_INVALID as for read_tflite().
Result<TfliteGraph> read_tflite_graph(std::span<const std::byte> bytes);

}  // namespace weir::engine
