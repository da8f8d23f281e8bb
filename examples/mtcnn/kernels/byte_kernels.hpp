// The inner loops of the networks with eight bits a number: products of four bytes at once, exact
// sums in int32, the same on every CPU. Fast where the CPU has VNNI.
#pragma once
#include <cstddef>
#include <cstdint>

#include "float_kernels.hpp"

namespace mtcnn::kernels {

// ConvolveRow's of bytes. `run` and what lies under it count in fours: weights of the bytes that a
// run is short of are zero, and the bytes may be anything.
struct ConvolveByteRow {
  const uint8_t* rows[3] = {};
  size_t height = 0;
  size_t quads = 0;  // of a run
  size_t in_step = 0;
  const int8_t* weights = nullptr;  // [height][quads][padded(outputs)][4]
  const float* scale = nullptr;     // of a sum: sum * scale + bias, then the PReLU
  const float* bias = nullptr;
  const float* slope = nullptr;
  size_t outputs = 0;
  // [pixels][padded(outputs)], one of the two: as they are; or plus `zero`, rounded, 0 to 255.
  float* numbers = nullptr;
  uint8_t* bytes = nullptr;
  float zero = 0;
  size_t pixels = 0;
};
void convolve(const ConvolveByteRow& row);

void pool(const PoolRow<uint8_t>& row);

}  // namespace mtcnn::kernels
