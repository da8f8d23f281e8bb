// Tests weir/detection.hpp: hand-computed overlaps, and suppression against a plain implementation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/detection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace detection_test {

using weir::Box;
using weir::Overlap;

TEST(Box, SidesAndArea) {
  const Box box{3, 5, 6, 9};
  EXPECT_EQ(box.width(), 3);
  EXPECT_EQ(box.height(), 4);
  EXPECT_EQ(box.area(), 12);
  EXPECT_EQ((Box{6, 5, 3, 9}.area()), 0) << "turned inside out";
  EXPECT_EQ((Box{6, 9, 3, 5}.area()), 0) << "twice";
  EXPECT_EQ((Box{NAN, 0, 1, 1}.area()), 0);
}

TEST(Box, Overlaps) {
  const Box a{0, 0, 4, 4}, b{2, 2, 6, 6}, inner{1, 1, 2, 2}, far{9, 9, 10, 10};
  EXPECT_FLOAT_EQ(overlap(a, b), 4.f / 28.f);
  EXPECT_FLOAT_EQ(overlap(a, a), 1);
  EXPECT_FLOAT_EQ(overlap(a, inner), 1.f / 16.f);
  EXPECT_FLOAT_EQ(overlap(a, inner, Overlap::OfSmaller), 1);
  EXPECT_EQ(overlap(a, far), 0);
  EXPECT_EQ(overlap(a, Box{4, 0, 8, 4}), 0) << "edges touch";
  EXPECT_EQ(overlap(Box{}, Box{}), 0) << "no area, no share";
  EXPECT_EQ(overlap(a, Box{NAN, NAN, NAN, NAN}), 0);
}

TEST(Box, SquaresAndMoves) {
  EXPECT_EQ(weir::square_around({0, 0, 4, 8}), (Box{-2, 0, 6, 8}));
  EXPECT_EQ(weir::square_around({0, 0, 8, 4}), (Box{0, -2, 8, 6}));
  EXPECT_EQ(weir::moved({10, 10, 20, 30}, 0.1f, 0.2f, -0.1f, 0.5f), (Box{11, 14, 19, 40}));
}

// Compares each box with all better ones by definition; quadratic.
std::vector<uint32_t> plainly(const std::vector<Box>& boxes, const std::vector<float>& scores,
                              const std::vector<float>& classes, float threshold, Overlap share) {
  std::vector<bool> gone(boxes.size(), false), done(boxes.size(), false);
  std::vector<uint32_t> out;
  for (;;) {
    size_t best = boxes.size();
    for (size_t i = 0; i < boxes.size(); ++i)
      if (!gone[i] && !done[i] && (best == boxes.size() || scores[i] > scores[best])) best = i;
    if (best == boxes.size()) return out;
    done[best] = true;
    out.push_back(static_cast<uint32_t>(best));
    for (size_t i = 0; i < boxes.size(); ++i) {
      const Box common = common_part(boxes[i], boxes[best]);
      const double inner = common.area();
      const double whole = share == Overlap::OfUnion
                               ? double{boxes[i].area()} + boxes[best].area() - inner
                               : std::min(boxes[i].area(), boxes[best].area());
      if (!done[i] && classes[i] == classes[best] && inner / whole > double{threshold})
        gone[i] = true;
    }
  }
}

TEST(Suppress, AgreesWithThePlainWay) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(0, 100), side(5, 40), score(0, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<Box> boxes;
    std::vector<float> scores, classes;
    for (int i = 0; i < 60; ++i) {
      const float x = place(random), y = place(random);
      boxes.push_back({x, y, x + side(random), y + side(random)});
      scores.push_back(score(random));
      classes.push_back(static_cast<float>(random() % 2));
    }
    const std::vector<float> one(boxes.size(), 0.f);
    for (const auto share : {Overlap::OfUnion, Overlap::OfSmaller}) {
      EXPECT_EQ(weir::suppress(boxes, scores, 0.3f, share),
                plainly(boxes, scores, one, 0.3f, share));
      EXPECT_EQ(weir::suppress(boxes, scores, 0.3f, share, classes),
                plainly(boxes, scores, classes, 0.3f, share));
    }
  }
}

TEST(Suppress, TakesTheEarlierOfEquals) {
  const std::vector<Box> boxes(3, Box{0, 0, 2, 2});
  EXPECT_EQ(weir::suppress(boxes, std::vector<float>{1, 1, 1}, 0.5f), std::vector<uint32_t>{0});
}

TEST(Suppress, LeavesOutWhatIsNoNumber) {
  const std::vector<Box> boxes{{0, 0, 2, 2}, {5, 5, 7, 7}, {0, 0, 2, 2}};
  const std::vector<float> scores{std::numeric_limits<float>::quiet_NaN(), 0.5f, 0.25f};
  EXPECT_EQ(weir::suppress(boxes, scores, 0.5f), (std::vector<uint32_t>{1, 2}));
  EXPECT_TRUE(weir::suppress({}, {}, 0.5f).empty());
}

TEST(DetectionRow, ReadsWhatItWrote) {
  std::vector<float> numbers(weir::DetectionRow<float>::length(2));
  ASSERT_EQ(numbers.size(), 10u);
  const weir::DetectionRow<float> row{std::span(numbers)};
  row.set_box({1, 2, 3, 4});
  row.score() = 0.5f, row.class_index() = 7;
  row.x(0) = 8, row.y(0) = 9, row.x(1) = 10, row.y(1) = 11;
  EXPECT_EQ(numbers, (std::vector<float>{1, 2, 3, 4, 0.5f, 7, 8, 9, 10, 11}));
  const weir::DetectionRow<const float> read{std::span<const float>(numbers)};
  EXPECT_EQ(read.box(), (Box{1, 2, 3, 4}));
  EXPECT_EQ(read.key_points(), 2u);
  EXPECT_EQ(read.y(1), 11);
}

}  // namespace detection_test
