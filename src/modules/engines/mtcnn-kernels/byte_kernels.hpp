// The inner loops of the 8-bit networks: products of four bytes at once with exact int32 sums, the
// same on every CPU. Fast on CPUs with VNNI.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "float_kernels.hpp"

namespace mtcnn::kernels {

// The 8-bit counterpart of ConvolveRow. A run is processed in quads of four bytes: the weights of
// bytes after the end of the run are zero, so these bytes may have any value.
struct ConvolveByteRow {
  const uint8_t* rows[3] = {};
  size_t height = 0;
  size_t quads = 0;  // per run
  size_t in_step = 0;
  const int8_t* weights = nullptr;  // [height][quads][padded(outputs)][4]
  const float* scale = nullptr;     // result = sum * scale + bias, then the PReLU
  const float* bias = nullptr;
  const float* slope = nullptr;
  size_t outputs = 0;
  // Set one of the two, [pixels][padded(outputs)]: values as they are, or plus `zero`, rounded and
  // clamped to 0..255.
  float* numbers = nullptr;
  uint8_t* bytes = nullptr;
  float zero = 0;
  size_t pixels = 0;
};
void convolve(const ConvolveByteRow& row);

void pool(const PoolRow<uint8_t>& row);

}  // namespace mtcnn::kernels
