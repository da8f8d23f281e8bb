// Tests of text regions: closed forms, and a search over all angles.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/text_regions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace weir::detection {
namespace text_regions_test {

constexpr double kPi = std::numbers::pi;

struct Map {
  size_t width, height;
  std::vector<float> values = std::vector<float>(width * height);

  void fill(size_t x1, size_t y1, size_t x2, size_t y2, float value) {
    for (size_t y = y1; y < y2; ++y)
      for (size_t x = x1; x < x2; ++x) values[y * width + x] = value;
  }
  // The pixels of a rotated rectangle.
  void turn(double cx, double cy, double w, double h, double angle, float value) {
    for (size_t y = 0; y < height; ++y)
      for (size_t x = 0; x < width; ++x) {
        const double dx = double(x) - cx, dy = double(y) - cy;
        if (std::abs(dx * std::cos(angle) + dy * std::sin(angle)) <= w / 2 &&
            std::abs(dy * std::cos(angle) - dx * std::sin(angle)) <= h / 2)
          values[y * width + x] = value;
      }
  }
  std::vector<TextRegion> find(const TextRegionOptions& options = {}) const {
    return find_text_regions(values, width, height, options);
  }
};

// What a box of these sides between the centres of pixels grows to on each side.
double growth(double width, double height, double ratio) {
  return width * height * ratio / (2 * (width + height));
}

TEST(TextRegions, AnUprightLineGrowsByItsRatio) {
  Map map{200, 100};
  map.fill(20, 30, 121, 46, 0.9f);
  const auto regions = map.find();
  ASSERT_EQ(regions.size(), 1u);
  const double d = growth(100, 15, 1.5);
  EXPECT_NEAR(regions[0].x, 70.5, 1e-4);
  EXPECT_NEAR(regions[0].y, 38, 1e-4);
  EXPECT_NEAR(regions[0].width, 100 + 2 * d, 1e-4);
  EXPECT_NEAR(regions[0].height, 15 + 2 * d, 1e-4);
  EXPECT_EQ(regions[0].angle, 0);
  EXPECT_NEAR(regions[0].score, 0.9, 1e-5);
}

TEST(TextRegions, ATurnedLineKeepsItsAngle) {
  for (const double degrees : {-40.0, -20.0, -5.0, 10.0, 30.0, 44.0}) {
    Map map{240, 240};
    map.turn(120, 118, 140, 20, degrees * kPi / 180, 1);
    const auto regions = map.find({.unclip = 0});
    ASSERT_EQ(regions.size(), 1u) << degrees;
    EXPECT_NEAR(regions[0].angle, degrees * kPi / 180, 0.03) << degrees;
    EXPECT_NEAR(regions[0].width, 140, 3) << degrees;
    EXPECT_NEAR(regions[0].height, 20, 3) << degrees;
    EXPECT_NEAR(regions[0].x, 120.5, 1) << degrees;
    EXPECT_NEAR(regions[0].y, 118.5, 1) << degrees;
  }
}

TEST(TextRegions, TallBoxesAreReadFromTopToBottom) {
  Map map{100, 200};
  map.fill(40, 20, 56, 180, 1);
  auto regions = map.find({.unclip = 0});
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_NEAR(regions[0].angle, kPi / 2, 1e-6);
  EXPECT_NEAR(regions[0].width, 159, 1e-4);
  EXPECT_NEAR(regions[0].height, 15, 1e-4);
  Map less_tall{100, 100};
  less_tall.fill(40, 20, 61, 50, 1);  // 29 / 20 < 1.5
  regions = less_tall.find({.unclip = 0});
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_EQ(regions[0].angle, 0);
  EXPECT_NEAR(regions[0].height, 29, 1e-4);
}

TEST(TextRegions, PixelsThatTouchAtACornerBelongTogether) {
  Map map{60, 60};
  map.fill(10, 10, 20, 20, 1);
  map.fill(20, 20, 30, 30, 1);
  EXPECT_EQ(map.find({.min_score = 0.1f}).size(), 1u);
  map.fill(20, 20, 30, 21, 0);
  EXPECT_EQ(map.find({.min_score = 0.1f}).size(), 2u);
}

TEST(TextRegions, ArmsJoinBelow) {
  Map map{60, 60};  // a U: two areas until the last rows
  map.fill(10, 10, 15, 40, 1);
  map.fill(30, 10, 35, 40, 1);
  EXPECT_EQ(map.find({.min_score = 0.1f}).size(), 2u);
  map.fill(10, 36, 35, 40, 1);
  EXPECT_EQ(map.find({.min_score = 0.1f}).size(), 1u);
}

TEST(TextRegions, TheScoreIsTheMeanInTheBox) {
  Map map{60, 60};
  map.fill(10, 10, 30, 20, 0.8f);
  map.fill(10, 10, 20, 20, 0.4f);
  EXPECT_NEAR(map.find({.min_score = 0.5f}).at(0).score, 0.6, 1e-5);
  EXPECT_TRUE(map.find({.min_score = 0.61f}).empty());
}

TEST(TextRegions, AMapOfOnesIsOneRegion) {
  Map map{64, 32};
  map.fill(0, 0, 64, 32, 1);
  const auto regions = map.find();
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_NEAR(regions[0].x, 32, 1e-4);
  EXPECT_NEAR(regions[0].width, 63 + 2 * growth(63, 31, 1.5), 1e-3);
  EXPECT_EQ(regions[0].score, 1);
}

TEST(TextRegions, SmallAreasAreLeftOut) {
  Map map{60, 60};
  map.fill(10, 10, 13, 50, 1);  // 2 pixels between centres
  EXPECT_TRUE(map.find().empty());
  map.fill(10, 10, 14, 50, 1);
  EXPECT_EQ(map.find().size(), 1u);
}

TEST(TextRegions, AHundredThousandPixelsApartAreNothing) {
  Map map{640, 640};
  for (size_t y = 0; y < 640; y += 2)
    for (size_t x = 0; x < 640; x += 2) map.values[y * 640 + x] = 1;
  EXPECT_TRUE(map.find().empty());
}

TEST(TextRegions, NumbersThatAreNotFiniteAreNoText) {
  Map map{64, 64};
  map.fill(0, 0, 64, 64, NAN);
  EXPECT_TRUE(map.find().empty());
  map.fill(0, 0, 64, 64, -INFINITY);
  EXPECT_TRUE(map.find().empty());
  map.fill(10, 10, 40, 20, INFINITY);
  ASSERT_EQ(map.find().size(), 1u);
  EXPECT_EQ(map.find()[0].score, 1);
  EXPECT_TRUE(find_text_regions({}, 0, 0, {}).empty());
}

// All pixels that are connected with the first set one.
std::vector<std::pair<int, int>> connected(const Map& map) {
  std::vector<char> known(map.values.size());
  std::vector<std::pair<int, int>> out;
  for (size_t i = 0; i < map.values.size() && out.empty(); ++i)
    if (map.values[i] > 0.5f) {
      out.emplace_back(int(i % map.width), int(i / map.width));
      known[i] = 1;
    }
  for (size_t next = 0; next < out.size(); ++next)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = out[next].first + dx, y = out[next].second + dy;
        if (x < 0 || y < 0 || x >= int(map.width) || y >= int(map.height)) continue;
        const size_t i = size_t(y) * map.width + size_t(x);
        if (known[i] || map.values[i] <= 0.5f) continue;
        known[i] = 1;
        out.emplace_back(x, y);
      }
  return out;
}

TEST(TextRegions, BoxesAreTheSmallestThatContainTheArea) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> place(15, 45), size(7, 20);
  for (int round = 0; round < 40; ++round) {
    Map map{80, 80};
    for (int i = 0; i < 4; ++i) {  // squares that overlap
      const int x = place(random), y = place(random), w = size(random), h = size(random);
      map.fill(size_t(x), size_t(y), size_t(x + w), size_t(y + h), 1);
    }
    const auto regions = map.find({.min_pixel = 0.5f, .min_score = 0, .unclip = 0});
    ASSERT_FALSE(regions.empty());
    const auto pixels = connected(map);
    double smallest = INFINITY;
    for (double angle = 0; angle < kPi / 2; angle += kPi / 720) {
      double u1 = INFINITY, u2 = -INFINITY, v1 = INFINITY, v2 = -INFINITY;
      for (const auto& [x, y] : pixels) {
        const double u = x * std::cos(angle) + y * std::sin(angle),
                     v = y * std::cos(angle) - x * std::sin(angle);
        u1 = std::min(u1, u), u2 = std::max(u2, u), v1 = std::min(v1, v), v2 = std::max(v2, v);
      }
      smallest = std::min(smallest, (u2 - u1) * (v2 - v1));
    }
    const TextRegion& box = regions[0];
    EXPECT_LE(double{box.width} * box.height, smallest + 0.01) << round;
    for (const auto& [x, y] : pixels) {
      const double dx = x + 0.5 - box.x, dy = y + 0.5 - box.y;
      const double c = std::cos(box.angle), s = std::sin(box.angle);
      EXPECT_LE(std::abs(dx * c + dy * s), box.width / 2 + 0.01) << round;
      EXPECT_LE(std::abs(dy * c - dx * s), box.height / 2 + 0.01) << round;
    }
  }
}

}  // namespace text_regions_test
}  // namespace weir::detection
