// The inner loops of the float32 networks, for every vector width.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

namespace mtcnn::kernels {

// Output channels are computed in groups of this size; zeros pad the last group.
inline constexpr size_t kGroup = 16;
constexpr size_t padded(size_t channels) {
  return (channels + kGroup - 1) / kGroup * kGroup;
}
// Values that may be written after the end of a pooled row and read after any row, in whole groups.
inline constexpr size_t kRowMargin = 64;

// One output row of a convolution with PReLU. The channels of a pixel are contiguous, so the pixels
// under one row of the kernel form one run of values. A fully connected layer over many regions is
// the same with a kernel of one row, where each pixel is a region.
struct ConvolveRow {
  const float* rows[3] = {};       // input rows, one for each row of the kernel, at its first pixel
  size_t height = 0;               // rows of the kernel
  size_t run = 0;                  // values under one row of the kernel
  size_t in_step = 0;              // values from one pixel to the next
  const float* weights = nullptr;  // [height][run][padded(outputs)]
  const float* bias = nullptr;     // [padded(outputs)], as `slope`, which is 1 without PReLU
  const float* slope = nullptr;
  size_t outputs = 0;    // channels
  float* out = nullptr;  // [pixels][padded(outputs)]
  size_t pixels = 0;
};
void convolve(const ConvolveRow& row);

// Maximum over `height` rows and `width` columns, at every second pixel. Columns after the last
// pixel of a row are ignored.
template <class Number>
struct PoolRow {
  const Number* rows[3] = {};
  size_t height = 0, width = 0;
  size_t channels = 0, in_step = 0, out_step = 0;  // steps: values from one pixel to the next
  size_t in_pixels = 0, out_pixels = 0;
  Number* out = nullptr;
};
void pool(const PoolRow<float>& row);

// out[i] = in[i]
void widen(const uint8_t* in, size_t count, float* out);

}  // namespace mtcnn::kernels
