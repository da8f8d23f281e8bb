// PackedLayer: one layer, with its weights in the order in which a kernel reads them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "byte_kernels.hpp"
#include "networks.hpp"

namespace mtcnn::kernels {

// Quantisation of a byte: value = (byte - zero) * step.
struct Scale {
  float step = 1, zero = 0;
  static Scale of(const Range& range) {
    const float step = (range.max - range.min) / 255;
    return {step, -range.min / step};
  }
};
// The networks' input is (byte - 127.5) / 128 for each byte of the picture.
inline constexpr Scale kPixels{1.f / 128, 127.5f};

// Values per pixel, as a kernel reads them.
template <class Number>
constexpr size_t get_step(size_t channels) {
  return sizeof(Number) == 1 && channels > 3 ? (channels + 3) / 4 * 4 : channels;
}

template <class Number>
class PackedLayer;

template <>
class PackedLayer<float> {
 public:
  // `in` and `out` are the quantisation of the values before and after the layer. This layer uses
  // only that of a picture: all other values are unquantised.
  PackedLayer(const Layer& layer, const Scale& in, const Scale& out);
  // `rows`: one for each row of the layer's kernel. out: [pixels][padded(outputs)].
  void apply(const float* const* rows, size_t in_step, size_t pixels, float* out) const;

 private:
  size_t kernel_, inputs_, outputs_;
  std::vector<float> weights_, bias_, slope_;
};

template <>
class PackedLayer<uint8_t> {
 public:
  PackedLayer(const Layer& layer, const Scale& in, const Scale& out);
  void apply(const uint8_t* const* rows, size_t in_step, size_t pixels, uint8_t* out) const;
  // Writes unquantised values: the constructor's `out` has the step 1.
  void apply(const uint8_t* const* rows, size_t in_step, size_t pixels, float* out) const;

 private:
  ConvolveByteRow row(const uint8_t* const* rows, size_t in_step, size_t pixels) const;
  size_t kernel_, quads_, outputs_;
  std::vector<int8_t> weights_;
  std::vector<float> scale_, bias_, slope_;
  float zero_;
};

}  // namespace mtcnn::kernels
