// RowMaps: computes the convolutions and poolings of a network row by row. Each stage keeps only
// the rows that the next one reads, so that all of them stay in the cache.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <vector>

#include "layers.hpp"

namespace mtcnn::kernels {

// `Number`: float, or uint8_t for 8-bit values.
template <class Number>
class RowMaps {
 public:
  explicit RowMaps(const Network& network);

  // Sets the size of the pictures: bytes with interleaved colours.
  void set_size(size_t width, size_t height);
  size_t width() const { return stages_.back().width; }
  size_t height() const { return stages_.back().height; }
  size_t channels() const { return stages_.back().channels; }  // also the step between pixels

  // Starts a picture; it is borrowed.
  void begin(const uint8_t* picture);
  // Returns row y of the last layer's output, valid until the next call. y must not decrease.
  const Number* row(size_t y) { return make(stages_.size() - 1, y); }
  // Computes all rows into `out`: [height][width][channels].
  void all(Number* out);
  // The quantisation of the last layer's output.
  Scale scale() const { return scale_; }

 private:
  struct Stage {
    size_t kernel = 1, stride = 1;
    bool pools = false;
    const PackedLayer<Number>* layer = nullptr;
    size_t channels = 0, step = 0;           // of the output
    size_t width = 0, height = 0, kept = 1;  // kept: rows in memory
    size_t made = 0;                         // rows computed so far
    std::vector<Number> rows;
    size_t row_size() const { return width * step + kRowMargin; }
    Number* row(size_t y) { return rows.data() + y % kept * row_size(); }
  };
  const Number* make(size_t stage, size_t y);
  void make_row(size_t stage, size_t y);

  std::vector<PackedLayer<Number>> layers_;
  std::vector<Stage> stages_;  // the first stage is the picture
  Scale scale_;
  const uint8_t* picture_ = nullptr;
};

template <class Number>
RowMaps<Number>::RowMaps(const Network& network) : scale_(kPixels) {
  const auto plans = network.plan->convolutions;
  layers_.reserve(plans.size());
  Stage picture;
  picture.channels = picture.step = 3;
  stages_.push_back(std::move(picture));
  for (size_t i = 0; i < plans.size(); ++i) {
    const Scale out = Scale::of(plans[i].range);
    layers_.emplace_back(network.layers[i], scale_, out);
    scale_ = sizeof(Number) == 1 ? out : Scale{};
    Stage stage;
    stage.kernel = plans[i].kernel;
    stage.layer = &layers_.back();
    stage.channels = plans[i].outputs;
    stage.step = padded(stage.channels);
    stages_.push_back(stage);
    if (plans[i].pool == 0) continue;
    stage.pools = true;
    stage.kernel = plans[i].pool;
    stage.stride = 2;
    stage.step = get_step<Number>(stage.channels);
    stages_.push_back(std::move(stage));
  }
}

template <class Number>
void RowMaps<Number>::set_size(size_t width, size_t height) {
  if (stages_[0].width == width && stages_[0].height == height) return;
  for (size_t i = 0; i < stages_.size(); ++i) {
    Stage& stage = stages_[i];
    if (stage.pools) {  // rounded up
      width = width <= stage.kernel ? 1 : (width - stage.kernel + 1) / 2 + 1;
      height = height <= stage.kernel ? 1 : (height - stage.kernel + 1) / 2 + 1;
    } else if (i > 0) {
      width -= stage.kernel - 1;
      height -= stage.kernel - 1;
    }
    stage.width = width;
    stage.height = height;
    stage.kept = i + 1 < stages_.size() ? stages_[i + 1].kernel : 1;
    stage.rows.assign(stage.kept * stage.row_size(), Number{});
  }
}

template <class Number>
void RowMaps<Number>::begin(const uint8_t* picture) {
  picture_ = picture;
  for (auto& stage : stages_) stage.made = 0;
}

template <class Number>
const Number* RowMaps<Number>::make(size_t number, size_t y) {
  Stage& stage = stages_[number];
  for (; stage.made <= y; ++stage.made) make_row(number, stage.made);
  return stage.row(y);
}

template <class Number>
void RowMaps<Number>::make_row(size_t number, size_t y) {
  Stage& stage = stages_[number];
  if (number == 0) {
    const size_t count = stage.width * stage.step;
    if constexpr (sizeof(Number) == 1)
      std::copy_n(picture_ + y * count, count, stage.row(y));
    else
      widen(picture_ + y * count, count, stage.row(y));
    return;
  }
  Stage& in = stages_[number - 1];
  const Number* rows[3] = {};
  const size_t count = std::min(stage.kernel, in.height - y * stage.stride);
  make(number - 1, y * stage.stride + count - 1);
  for (size_t r = 0; r < count; ++r) rows[r] = in.row(y * stage.stride + r);
  if (!stage.pools) return stage.layer->apply(rows, in.step, stage.width, stage.row(y));
  PoolRow<Number> pooled;
  std::copy_n(rows, count, pooled.rows);
  pooled.height = count;
  pooled.width = stage.kernel;
  pooled.channels = stage.channels;
  pooled.in_step = in.step;
  pooled.out_step = stage.step;
  pooled.in_pixels = in.width;
  pooled.out_pixels = stage.width;
  pooled.out = stage.row(y);
  pool(pooled);
}

template <class Number>
void RowMaps<Number>::all(Number* out) {
  for (size_t y = 0; y < height(); ++y) out = std::copy_n(row(y), width() * channels(), out);
}

}  // namespace mtcnn::kernels
