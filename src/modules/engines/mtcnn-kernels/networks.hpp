// The three networks (Zhang et al., arXiv:1604.02878): their layers, and reading weights from a
// file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace mtcnn::kernels {

// The range of a layer's values, for 8-bit quantisation.
struct Range {
  float min, max;
};

// A convolution without padding, PReLU and max pooling over pool x pool pixels with stride 2,
// rounding the size up; no pooling when `pool` is 0.
struct ConvolutionPlan {
  uint32_t kernel, inputs, outputs, pool;
  Range range;
};
struct NetworkPlan {
  const char* name;
  uint32_t side;  // width and height of the picture whose maps have one pixel
  std::span<const ConvolutionPlan> convolutions;
  uint32_t features;  // values per region after the convolutions
  uint32_t dense;  // outputs of the fully connected layer; 0: none, and pictures may have any size
  Range dense_range;
  std::span<const uint32_t> heads;  // outputs: 2 (before a softmax), 4, 10
  uint32_t head_outputs() const {
    uint32_t sum = 0;
    for (const uint32_t one : heads) sum += one;
    return sum;
  }
};
std::span<const NetworkPlan> network_plans();

// [outputs][kernel][kernel][inputs]; the kernel of a fully connected layer is 1.
struct Layer {
  uint32_t kernel = 1, inputs = 0, outputs = 0;
  std::vector<float> weights, bias;
  std::vector<float> slope;  // PReLU slopes; empty without PReLU
};
struct Network {
  const NetworkPlan* plan = nullptr;
  std::vector<Layer> layers;  // convolutions, the fully connected layer if any, all heads as one
};

// Reads an ONNX file with one of the networks: for pictures with colour planes, or for pictures
// with rows and columns exchanged and interleaved colours, recognised by its Transpose.
// MODEL_INVALID for a damaged file, MODEL_UNSUPPORTED for another network.
weir::Result<Network> read_network(std::span<const std::byte> file, const std::string& name);

}  // namespace mtcnn::kernels
