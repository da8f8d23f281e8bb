// Tests of masks, against the bilinear interpolation written out in double precision.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/instance_masks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace weir::detection {
namespace instance_masks_test {

struct Sample {
  std::vector<float> planes;  // one after the other
  size_t width, height, count;

  // Of cells beyond the border, the nearest.
  double sum(int64_t x, int64_t y, const std::vector<float>& weights) const {
    const auto column = static_cast<size_t>(std::clamp<int64_t>(x, 0, int64_t(width) - 1));
    const auto row = static_cast<size_t>(std::clamp<int64_t>(y, 0, int64_t(height) - 1));
    double out = 0;
    for (size_t i = 0; i < count; ++i)
      out += double{weights[i]} * planes[(i * height + row) * width + column];
    return out;
  }
  double probability(double x, double y, const std::vector<float>& weights) const {
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const double over = x - 0.5 - left, down = y - 0.5 - top;
    const auto at = [&](int dx, int dy) {
      return sum(int64_t(left) + dx, int64_t(top) + dy, weights);
    };
    const double upper = at(0, 0) * (1 - over) + at(1, 0) * over;
    const double lower = at(0, 1) * (1 - over) + at(1, 1) * over;
    return 1 / (1 + std::exp(-(upper * (1 - down) + lower * down)));
  }
};

Sample make_sample(size_t width, size_t height, size_t count) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0, 1);
  Sample out{{}, width, height, count};
  for (size_t i = 0; i < width * height * count; ++i) out.planes.push_back(normal(random));
  return out;
}

std::vector<uint8_t> draw(const Sample& sample, bool are_packed, const std::vector<float>& weights,
                          const Box& box, uint32_t width, uint32_t height) {
  std::vector<float> values = sample.planes;
  const size_t cells = sample.width * sample.height;
  if (are_packed)
    for (size_t cell = 0; cell < cells; ++cell)
      for (size_t i = 0; i < sample.count; ++i)
        values[cell * sample.count + i] = sample.planes[i * cells + cell];
  std::vector<uint8_t> out(size_t{width} * height, 7);
  InstanceMasks().draw({values, sample.width, sample.height, sample.count, are_packed}, weights,
                       box, width, height, out);
  return out;
}

TEST(InstanceMasks, InterpolateTheWeightedSumOfPrototypes) {
  const Sample sample = make_sample(12, 9, 5);
  const std::vector<float> weights{0.5f, -1, 2, 0.25f, -0.75f};
  for (const Box& box : {Box{2, 1, 9, 7}, Box{0, 0, 12, 9}, Box{3.25f, 2.5f, 3.75f, 8.9f},
                         Box{-5, -3, 4, 20}, Box{20, 20, 30, 30}})
    for (const auto& [width, height] : {std::pair{7u, 6u}, std::pair{1u, 1u}, std::pair{30u, 2u}})
      for (const bool are_packed : {false, true}) {
        const auto mask = draw(sample, are_packed, weights, box, width, height);
        for (uint32_t y = 0; y < height; ++y)
          for (uint32_t x = 0; x < width; ++x) {
            const double at_x = box.x1 + (x + 0.5) * double{box.width()} / width;
            const double at_y = box.y1 + (y + 0.5) * double{box.height()} / height;
            EXPECT_NEAR(mask[y * width + x], 255 * sample.probability(at_x, at_y, weights), 0.51);
          }
      }
}

TEST(InstanceMasks, ABoxWithoutExtentAndSumsThatAreNotNumbersAreEmpty) {
  const Sample sample = make_sample(4, 4, 2);
  const std::vector<uint8_t> empty(4);
  for (const Box& box : {Box{1, 1, 1, 3}, Box{3, 1, 1, 3}, Box{1, NAN, 3, 3}})
    EXPECT_EQ(draw(sample, false, {1, 1}, box, 2, 2), empty);
  EXPECT_EQ(draw(sample, false, {NAN, 1}, {0, 0, 4, 4}, 2, 2), empty);
  EXPECT_EQ(draw(sample, true, {INFINITY, -INFINITY}, {-INFINITY, 0, INFINITY, 4}, 2, 2).size(),
            4u);
}

}  // namespace instance_masks_test
}  // namespace weir::detection
