// The inner loops of the networks in float32, for every vector width.
#pragma once
#include <cstddef>
#include <cstdint>

namespace mtcnn::kernels {

// Output channels are computed in groups of as many; the last group is filled up with zeros.
inline constexpr size_t kGroup = 16;
constexpr size_t padded(size_t channels) {
  return (channels + kGroup - 1) / kGroup * kGroup;
}
// Numbers that may be written behind the end of a pooled row and read behind any: whole groups are.
inline constexpr size_t kRowMargin = 64;

// A row of a convolution with its PReLU. Numbers of a pixel's channels lie beside each other, so
// the pixels under one row of the kernel are one run of numbers. A fully connected layer of many
// regions is the same: a kernel of one row, whose pixels are regions.
struct ConvolveRow {
  const float* rows[3] = {};  // of the input, one for each row of the kernel, at its first pixel
  size_t height = 0;          // of the kernel
  size_t run = 0;             // numbers under one row of the kernel
  size_t in_step = 0;         // numbers from one pixel to the next
  const float* weights = nullptr;  // [height][run][padded(outputs)]
  const float* bias = nullptr;  // [padded(outputs)], as `slope`, which is 1 where there is no PReLU
  const float* slope = nullptr;
  size_t outputs = 0;    // channels
  float* out = nullptr;  // [pixels][padded(outputs)]
  size_t pixels = 0;
};
void convolve(const ConvolveRow& row);

// The largest of `height` rows and `width` columns of pixels at every second pixel; what would lie
// behind the last pixel of a row counts nothing.
template <class Number>
struct PoolRow {
  const Number* rows[3] = {};
  size_t height = 0, width = 0;
  size_t channels = 0, in_step = 0, out_step = 0;  // numbers from one pixel to the next
  size_t in_pixels = 0, out_pixels = 0;
  Number* out = nullptr;
};
void pool(const PoolRow<float>& row);

// out[i] = in[i]
void widen(const uint8_t* in, size_t count, float* out);

}  // namespace mtcnn::kernels
