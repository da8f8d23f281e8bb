// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/instance_masks.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/sigmoid.hpp"

namespace weir::detection {
namespace {

// The two cells around a position, and the weight of the second.
struct Between {
  size_t low = 0, high = 0;
  float weight = 0;
};
Between between(float position, size_t count) noexcept {
  // Unlike std::clamp, these return the limit for a position that is not a number.
  const float at = std::fmin(std::fmax(position - 0.5f, 0.0f), static_cast<float>(count - 1));
  const auto low = static_cast<size_t>(at);
  return {low, std::min(low + 1, count - 1), at - static_cast<float>(low)};
}

// The position of sample `index` of `count` samples between two edges.
float sample_at(float from, float to, uint32_t index, uint32_t count) noexcept {
  return from + (static_cast<float>(index) + 0.5f) * (to - from) / static_cast<float>(count);
}

uint8_t to_probability(float sum) noexcept {
  const float probability = sigmoid(sum);
  return std::isnan(probability) ? uint8_t{0}
                                 : static_cast<uint8_t>(std::lround(probability * 255));
}

}  // namespace

void InstanceMasks::sum(const Prototypes& prototypes, std::span<const float> weights,
                        const Region& region) {
  sums_.assign(region.width * region.height, 0.0f);
  for (size_t y = 0; y < region.height; ++y) {
    float* to = sums_.data() + y * region.width;
    const size_t cell = (region.top + y) * prototypes.width + region.left;
    if (prototypes.are_packed) {
      for (size_t x = 0; x < region.width; ++x) {
        const float* from = prototypes.values.data() + (cell + x) * prototypes.count;
        for (size_t i = 0; i < prototypes.count; ++i) to[x] += weights[i] * from[i];
      }
      continue;
    }
    const size_t plane = prototypes.width * prototypes.height;
    for (size_t i = 0; i < prototypes.count; ++i) {
      const float* from = prototypes.values.data() + i * plane + cell;
      const float weight = weights[i];
      for (size_t x = 0; x < region.width; ++x) to[x] += weight * from[x];
    }
  }
}

void InstanceMasks::draw(const Prototypes& prototypes, std::span<const float> weights,
                         const Box& box, uint32_t width, uint32_t height, std::span<uint8_t> out) {
  if (!(box.x2 > box.x1 && box.y2 > box.y1) || prototypes.width == 0 || prototypes.height == 0) {
    std::fill(out.begin(), out.end(), uint8_t{0});
    return;
  }
  std::vector<Between> columns(width), rows(height);
  for (uint32_t x = 0; x < width; ++x)
    columns[x] = between(sample_at(box.x1, box.x2, x, width), prototypes.width);
  for (uint32_t y = 0; y < height; ++y)
    rows[y] = between(sample_at(box.y1, box.y2, y, height), prototypes.height);
  const Region region{columns.front().low, rows.front().low,
                      columns.back().high - columns.front().low + 1,
                      rows.back().high - rows.front().low + 1};
  sum(prototypes, weights, region);
  for (uint32_t y = 0; y < height; ++y) {
    const float* top = sums_.data() + (rows[y].low - region.top) * region.width;
    const float* bottom = sums_.data() + (rows[y].high - region.top) * region.width;
    for (uint32_t x = 0; x < width; ++x) {
      const size_t left = columns[x].low - region.left, right = columns[x].high - region.left;
      const float over = columns[x].weight, down = rows[y].weight;
      const float upper = top[left] + (top[right] - top[left]) * over;
      const float lower = bottom[left] + (bottom[right] - bottom[left]) * over;
      out[size_t{y} * width + x] = to_probability(upper + (lower - upper) * down);
    }
  }
}

}  // namespace weir::detection
