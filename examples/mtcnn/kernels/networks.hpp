// The three networks (Zhang et al., arXiv:1604.02878): their layers, and what a file's weights are.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace mtcnn::kernels {

// What a layer's numbers lie between, for eight bits a number.
struct Range {
  float least, most;
};

// A convolution without border, PReLU, and the largest of pool x pool pixels at every second one,
// counted up; no pooling where `pool` is 0.
struct ConvolutionPlan {
  uint32_t kernel, inputs, outputs, pool;
  Range range;
};
struct NetworkPlan {
  const char* name;
  uint32_t side;  // of the picture at which the maps have one pixel
  std::span<const ConvolutionPlan> convolutions;
  uint32_t features;  // numbers that the convolutions leave of a region
  uint32_t dense;  // of the fully connected layer; 0: it has none, and takes pictures of any size
  Range dense_range;
  std::span<const uint32_t> heads;  // outputs: 2, of which a softmax is taken; 4; 10
  uint32_t head_outputs() const {
    uint32_t sum = 0;
    for (const uint32_t one : heads) sum += one;
    return sum;
  }
};
std::span<const NetworkPlan> network_plans();

// [outputs][kernel][kernel][inputs]; a fully connected layer has a kernel of 1.
struct Layer {
  uint32_t kernel = 1, inputs = 0, outputs = 0;
  std::vector<float> weights, bias;
  std::vector<float> slope;  // of the PReLU; empty: none
};
struct Network {
  const NetworkPlan* plan = nullptr;
  std::vector<Layer>
      layers;  // convolutions, the fully connected one if there is one, all heads as one
};

// Of an ONNX file that holds one of them: for pictures as they are with planes of colours, or for
// pictures with rows and columns exchanged and colours beside each other, which is known by its
// Transpose. MODEL_INVALID for a file that is damaged, MODEL_UNSUPPORTED for another network.
weir::Result<Network> read_network(std::span<const std::byte> file, const std::string& name);

}  // namespace mtcnn::kernels
