// The nodes and constants of an ONNX file (onnx.proto of the ONNX project), float32 alone.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace mtcnn::kernels {

struct OnnxTensor {
  std::vector<int64_t> shape;
  std::vector<float> numbers;
};
struct OnnxNode {
  std::string type;  // a Transpose's with its order: "Transpose_0312"
  std::vector<std::string> inputs;
  std::string output;  // the first
};
struct OnnxGraph {
  std::vector<OnnxNode> nodes;  // in the order of the file
  std::map<std::string, OnnxTensor, std::less<>> constants;
  // Null when it is no float32 constant.
  const OnnxTensor* tensor(const std::string& name) const {
    const auto found = constants.find(name);
    return found == constants.end() ? nullptr : &found->second;
  }
};

// MODEL_INVALID for what is damaged or has fewer numbers than its shapes say.
weir::Result<OnnxGraph> read_graph(std::span<const std::byte> file, const std::string& name);

}  // namespace mtcnn::kernels
