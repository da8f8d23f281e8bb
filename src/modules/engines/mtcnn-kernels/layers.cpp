// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mtcnn::kernels {
namespace {

// The PReLU slopes; 1 without PReLU.
std::vector<float> slopes(const Layer& layer) {
  std::vector<float> out(padded(layer.outputs), 1.f);
  std::ranges::copy(layer.slope, out.begin());
  return out;
}

size_t numbers_of_output(const Layer& layer) {
  return size_t{layer.kernel} * layer.kernel * layer.inputs;
}

}  // namespace

PackedLayer<float>::PackedLayer(const Layer& layer, const Scale& in, const Scale&)
    : kernel_(layer.kernel),
      inputs_(layer.inputs),
      outputs_(layer.outputs),
      weights_(numbers_of_output(layer) * padded(outputs_)),
      bias_(padded(outputs_)),
      slope_(slopes(layer)) {
  const size_t count = numbers_of_output(layer), stride = padded(outputs_);
  for (size_t o = 0; o < outputs_; ++o) {
    double sum = 0;
    for (size_t k = 0; k < count; ++k) {
      const float weight = layer.weights[o * count + k] * in.step;
      weights_[k * stride + o] = weight;
      sum += weight;
    }
    bias_[o] = static_cast<float>(layer.bias[o] - sum * in.zero);
  }
}

void PackedLayer<float>::apply(const float* const* rows, size_t in_step, size_t pixels,
                               float* out) const {
  ConvolveRow row;
  std::copy_n(rows, kernel_, row.rows);
  row.height = kernel_;
  row.run = kernel_ * inputs_;
  row.in_step = in_step;
  row.weights = weights_.data();
  row.bias = bias_.data();
  row.slope = slope_.data();
  row.outputs = outputs_;
  row.out = out;
  row.pixels = pixels;
  convolve(row);
}

PackedLayer<uint8_t>::PackedLayer(const Layer& layer, const Scale& in, const Scale& out)
    : kernel_(layer.kernel),
      quads_((layer.kernel * get_step<uint8_t>(layer.inputs) + 3) / 4),
      outputs_(layer.outputs),
      weights_(kernel_ * quads_ * 4 * padded(outputs_)),
      scale_(padded(outputs_)),
      bias_(padded(outputs_)),
      slope_(slopes(layer)),
      zero_(out.zero) {
  const size_t count = numbers_of_output(layer), step = get_step<uint8_t>(layer.inputs);
  for (size_t o = 0; o < outputs_; ++o) {
    const float* weights = &layer.weights[o * count];
    float max = 0;
    for (size_t k = 0; k < count; ++k) max = std::max(max, std::abs(weights[k]));
    const float unit = std::max(max / 127, std::numeric_limits<float>::min());
    long sum = 0;
    for (size_t k = 0; k < count; ++k) {
      const size_t row = k / (kernel_ * layer.inputs), rest = k % (kernel_ * layer.inputs);
      const size_t byte = rest / layer.inputs * step + rest % layer.inputs;
      const long weight = std::lround(weights[k] / unit);
      weights_[((row * quads_ + byte / 4) * padded(outputs_) + o) * 4 + byte % 4] =
          static_cast<int8_t>(weight);
      sum += weight;
    }
    scale_[o] = unit * in.step / out.step;
    bias_[o] = layer.bias[o] / out.step - in.zero * static_cast<float>(sum) * scale_[o];
  }
}

ConvolveByteRow PackedLayer<uint8_t>::row(const uint8_t* const* rows, size_t in_step,
                                          size_t pixels) const {
  ConvolveByteRow row;
  std::copy_n(rows, kernel_, row.rows);
  row.height = kernel_;
  row.quads = quads_;
  row.in_step = in_step;
  row.weights = weights_.data();
  row.scale = scale_.data();
  row.bias = bias_.data();
  row.slope = slope_.data();
  row.outputs = outputs_;
  row.zero = zero_;
  row.pixels = pixels;
  return row;
}

void PackedLayer<uint8_t>::apply(const uint8_t* const* rows, size_t in_step, size_t pixels,
                                 uint8_t* out) const {
  ConvolveByteRow one = row(rows, in_step, pixels);
  one.bytes = out;
  convolve(one);
}

void PackedLayer<uint8_t>::apply(const uint8_t* const* rows, size_t in_step, size_t pixels,
                                 float* out) const {
  ConvolveByteRow one = row(rows, in_step, pixels);
  one.numbers = out;
  convolve(one);
}

}  // namespace mtcnn::kernels
