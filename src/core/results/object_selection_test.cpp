// Tests of non-maximum suppression, upright and rotated.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/object_selection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace weir::results {
namespace object_selection_test {

using detection::Candidate;
using detection::Candidates;

std::vector<uint32_t> rows(const Candidates& candidates) {
  std::vector<uint32_t> out;
  for (const auto& candidate : candidates) out.push_back(candidate.row);
  return out;
}

const Candidates kThree{
    {.x = 0, .y = 0, .width = 10, .height = 10, .score = 0.5f, .class_index = 0, .row = 0},
    {.x = 1, .y = 0, .width = 10, .height = 10, .score = 0.9f, .class_index = 0, .row = 1},
    {.x = 1, .y = 1, .width = 10, .height = 10, .score = 0.7f, .class_index = 1, .row = 2}};

TEST(Select, RemovesWeakerBoxesOfTheSameClass) {
  EXPECT_EQ(rows(select(kThree, {.rivals = SuppressionScope::SameClass})),
            (std::vector<uint32_t>{1, 2}));
  EXPECT_EQ(rows(select(kThree, {.rivals = SuppressionScope::AnyClass})),
            (std::vector<uint32_t>{1}));
  EXPECT_EQ(rows(select(kThree, {.rivals = SuppressionScope::None})),
            (std::vector<uint32_t>{1, 2, 0}));
}

TEST(Select, OverlapsUpToTheLimitStay) {
  // 9 * 10 of 2 * 100 - 90.
  const float overlap = 90.0f / 110;
  EXPECT_EQ(select(kThree, {.max_overlap = overlap + 0.001f}).size(), 3u);
  EXPECT_EQ(select(kThree, {.max_overlap = overlap - 0.001f}).size(), 2u);
}

TEST(Select, KeepsChosenClassesAndTheBestObjects) {
  const int32_t classes[] = {1, 5};
  EXPECT_EQ(rows(select(kThree, {.classes = classes})), (std::vector<uint32_t>{2}));
  EXPECT_EQ(rows(select(kThree, {.max_objects = 1})), (std::vector<uint32_t>{1}));
}

TEST(Select, EndsWithNoneAndWithAHundredThousand) {
  EXPECT_TRUE(select({}, {}).empty());
  Candidates many;
  for (uint32_t i = 0; i < 100000; ++i)
    many.push_back({.x = float(i), .width = 0.5f, .height = 1, .score = 0.5f, .row = i});
  const auto kept = select(many, {.max_objects = 100});
  ASSERT_EQ(kept.size(), 100u);
  EXPECT_EQ(kept[99].row, 99u);  // equal scores keep their order
}

TEST(RotatedOverlap, OfCrossedSquaresIsTheOctagons) {
  // Two unit squares with one centre, 45 degrees apart, have an octagon of area 2 * (sqrt 2 - 1).
  const Candidate a{.width = 1, .height = 1},
      b{.width = 1, .height = 1, .angle = std::numbers::pi_v<float> / 4};
  const double octagon = 2 * (std::sqrt(2.0) - 1);
  EXPECT_NEAR(rotated_overlap(a, b), octagon / (2 - octagon), 1e-6);
}

TEST(RotatedOverlap, IsThatOfUprightBoxesAtAngleZero) {
  const Candidate a{.x = 5, .y = 5, .width = 10, .height = 10};
  const Candidate b{.x = 6, .y = 5, .width = 10, .height = 10};
  EXPECT_NEAR(rotated_overlap(a, b), 90.0 / 110, 1e-6);
  const Candidate far{.x = 100, .y = 5, .width = 10, .height = 10};
  EXPECT_EQ(rotated_overlap(a, far), 0);
  EXPECT_EQ(rotated_overlap(a, Candidate{.x = 5, .y = 5}), 0);
}

TEST(RotatedOverlap, AgreesWithCountingPoints) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-3, 3), side(1, 6), angle(-4, 4);
  for (int i = 0; i < 20; ++i) {
    const Candidate a{.x = place(random),
                      .y = place(random),
                      .width = side(random),
                      .height = side(random),
                      .angle = angle(random)};
    const Candidate b{.x = place(random),
                      .y = place(random),
                      .width = side(random),
                      .height = side(random),
                      .angle = angle(random)};
    const auto contains = [](const Candidate& box, double x, double y) {
      const double c = std::cos(box.angle), s = std::sin(box.angle);
      const double dx = x - box.x, dy = y - box.y;
      return std::abs(dx * c + dy * s) <= box.width / 2 &&
             std::abs(-dx * s + dy * c) <= box.height / 2;
    };
    double both = 0, either = 0;
    for (double x = -10; x < 10; x += 0.02)
      for (double y = -10; y < 10; y += 0.02) {
        const bool in_a = contains(a, x, y), in_b = contains(b, x, y);
        both += in_a && in_b;
        either += in_a || in_b;
      }
    EXPECT_NEAR(rotated_overlap(a, b), both / either, 0.01) << i;
  }
}

}  // namespace object_selection_test
}  // namespace weir::results
