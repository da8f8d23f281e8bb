// OnnxGraph: the nodes and float32 constants of an ONNX file (onnx.proto of the ONNX project).
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
  std::string type;  // for Transpose with its order: "Transpose_0312"
  std::vector<std::string> inputs;
  std::string output;  // first output
};
struct OnnxGraph {
  std::vector<OnnxNode> nodes;  // in file order
  std::map<std::string, OnnxTensor, std::less<>> constants;
  // Null when there is no such float32 constant.
  const OnnxTensor* tensor(const std::string& name) const {
    const auto found = constants.find(name);
    return found == constants.end() ? nullptr : &found->second;
  }
};

// MODEL_INVALID for a damaged file or a tensor with fewer values than its shape.
weir::Result<OnnxGraph> read_graph(std::span<const std::byte> file, const std::string& name);

}  // namespace mtcnn::kernels
