// Tests of common_motion: what a camera does to all boxes, and what must not look like it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/motion.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace weir::track {
namespace motion_test {

using Boxes = std::vector<Box>;

Boxes row_of(size_t count) {
  Boxes out;
  for (size_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(100 * i);
    out.push_back({x, 50, x + 40, 150});
  }
  return out;
}
Boxes moved(Boxes boxes, float x, float y) {
  for (Box& b : boxes) b.x1 += x, b.x2 += x, b.y1 += y, b.y2 += y;
  return boxes;
}
void expect_none(const Shift& shift) {
  EXPECT_EQ(shift.x, 0);
  EXPECT_EQ(shift.y, 0);
}

TEST(CommonMotion, IsThatOfTheCamera) {
  for (const auto& [x, y] : {std::pair{12.f, -7.f}, {60.f, 0.f}, {-45.f, 30.f}}) {
    const Shift shift = common_motion(row_of(6), moved(row_of(6), x, y));
    EXPECT_FLOAT_EQ(shift.x, x);
    EXPECT_FLOAT_EQ(shift.y, y);
  }
}

TEST(CommonMotion, MissingAndFalseBoxesAndOneThatRunsDoNotChangeIt) {
  Boxes found = moved(row_of(7), 20, 5);
  found.erase(found.begin() + 2);
  found.push_back({350, 300, 390, 400});
  found[0] = moved({found[0]}, 50, 0)[0];
  const Shift shift = common_motion(row_of(7), found);
  EXPECT_FLOAT_EQ(shift.x, 20);
  EXPECT_FLOAT_EQ(shift.y, 5);
}

TEST(CommonMotion, TwoBoxesAreNoCamera) {
  expect_none(common_motion(row_of(2), moved(row_of(2), 20, 0)));
  expect_none(common_motion({}, row_of(3)));
  expect_none(common_motion(row_of(3), {}));
}

TEST(CommonMotion, PeopleWhoGoOppositeWaysAreNoCamera) {
  Boxes found = row_of(8);
  for (size_t i = 0; i < found.size(); ++i) found[i] = moved({found[i]}, i % 2 ? 30 : -30, 0)[0];
  found.resize(7);  // three of eight go one way, four the other way
  expect_none(common_motion(row_of(9), found));
}

TEST(CommonMotion, BoxesOfAnotherSizeAreOtherObjects) {
  Boxes found = moved(row_of(6), 20, 0);
  for (Box& b : found) b.y2 += 40;
  expect_none(common_motion(row_of(6), found));
}

TEST(CommonMotion, FartherThanAHeightIsNoCamera) {
  Boxes few;
  for (int i = 0; i < 4; ++i) few.push_back({1000.f * i, 0, 1000.f * i + 40, 100});
  expect_none(common_motion(few, moved(few, 101, 0)));
}

TEST(CommonMotion, NoiseOfTheBoxesIsNone) {
  // Three times deviation / sqrt(20), 2.4 standard errors of a median: 1.6 % by chance, and some
  // more because the deviation is an estimate from 20 values.
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 2);
  int shifts = 0;
  for (int round = 0; round < 1000; ++round) {
    Boxes found = row_of(20);
    for (Box& b : found) b = moved({b}, noise(random), 0)[0];
    shifts += common_motion(row_of(20), found).x != 0;
  }
  EXPECT_LT(shifts, 60);
}

TEST(CommonMotion, IsThatOfTheFirstBoxesInACrowd) {
  const Shift shift = common_motion(row_of(5000), moved(row_of(5000), 9, 0));
  EXPECT_FLOAT_EQ(shift.x, 9);
}

TEST(CommonMotion, NumbersThatAreNotFiniteAreNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect_none(common_motion(Boxes(4, {nan, nan, nan, nan}), Boxes(4, {nan, 0, nan, 9})));
}

}  // namespace motion_test
}  // namespace weir::track
