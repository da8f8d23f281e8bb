// SPDX-License-Identifier: LGPL-2.1-or-later
#include "runner.hpp"

#include <cmath>

#include "row_maps.hpp"

namespace mtcnn::kernels {
namespace {

// Softmax of two classes; the second is a face.
void softmax(const float* in, float* out) {
  const float face = 1 / (1 + std::exp(in[0] - in[1]));
  out[0] = 1 - face;
  out[1] = face;
}

template <class Number>
class RunnerOf final : public Runner {
 public:
  explicit RunnerOf(const Network& network)
      : plan_(*network.plan), maps_(network), heads_(network.layers.back(), head_scale(), Scale{}) {
    if (plan_.dense)
      dense_.emplace_back(network.layers[plan_.convolutions.size()], maps_.scale(),
                          Scale::of(plan_.dense_range));
  }

  MapSize map_size(size_t width, size_t height) const override {
    const auto less = [](size_t extent) { return (extent - 1) / 2 - 4; };
    return plan_.dense ? MapSize{1, 1} : MapSize{less(width), less(height)};
  }

  void run(const uint8_t* pictures, size_t count, size_t width, size_t height,
           float* const* out) override {
    maps_.set_size(width, height);
    if (plan_.dense) return regions(pictures, count, width * height * 3, out);
    size_t done = 0;
    for (size_t n = 0; n < count; ++n) {
      maps_.begin(pictures + n * width * height * 3);
      for (size_t y = 0; y < maps_.height(); ++y, done += maps_.width())
        heads(maps_.row(y), maps_.channels(), maps_.width(), done, out);
    }
  }

 private:
  Scale head_scale() const {
    if (sizeof(Number) != 1) return {};
    return plan_.dense ? Scale::of(plan_.dense_range) : maps_.scale();
  }

  void regions(const uint8_t* pictures, size_t count, size_t bytes, float* const* out) {
    features_.resize(count * plan_.features + kRowMargin);
    hidden_.resize(count * padded(plan_.dense) + kRowMargin);
    for (size_t n = 0; n < count; ++n) {
      maps_.begin(pictures + n * bytes);
      maps_.all(features_.data() + n * plan_.features);
    }
    const Number* rows[] = {features_.data()};
    dense_[0].apply(rows, plan_.features, count, hidden_.data());
    heads(hidden_.data(), padded(plan_.dense), count, 0, out);
  }

  // Computes `count` places, starting at `first`.
  void heads(const Number* in, size_t step, size_t count, size_t first, float* const* out) {
    const size_t stride = padded(plan_.head_outputs());
    sums_.resize(count * stride);
    const Number* rows[] = {in};
    heads_.apply(rows, step, count, sums_.data());
    const float* sums = sums_.data();
    size_t offset = 0;
    for (size_t h = 0; h < plan_.heads.size(); ++h) {
      const size_t outputs = plan_.heads[h];
      float* to = out[h] + first * outputs;
      for (size_t i = 0; i < count; ++i, to += outputs) {
        if (h == 0)
          softmax(sums + i * stride, to);
        else
          std::copy_n(sums + i * stride + offset, outputs, to);
      }
      offset += outputs;
    }
  }

  const NetworkPlan& plan_;
  RowMaps<Number> maps_;
  std::vector<PackedLayer<Number>> dense_;  // one or none
  PackedLayer<Number> heads_;
  std::vector<Number> features_, hidden_;
  std::vector<float> sums_;
};

}  // namespace

std::unique_ptr<Runner> make_runner(const Network& network, Precision precision) {
  if (precision == Precision::Int8) return std::make_unique<RunnerOf<uint8_t>>(network);
  return std::make_unique<RunnerOf<float>>(network);
}

}  // namespace mtcnn::kernels
