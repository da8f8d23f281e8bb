// Tests of boxes in whole pixels: conversion, overlap, suppression and tracking.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>

#include "core/detection/centroid_tracker.hpp"
#include "core/detection/pixel_box.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {
namespace boxes_test {

constexpr Size kPicture{100, 50};

PixelBox box(int32_t x, int32_t y, int32_t width, int32_t height, float probability = 0.5f) {
  return {x, y, width, height, 0, probability, 0};
}

TEST(PixelBox, TruncatesTowardsZero) {
  const Candidate candidate{
      .x = -1.75f, .y = 2.75f, .width = 3.99f, .height = -0.5f, .score = 0.5f, .class_index = 4};
  EXPECT_EQ(to_pixels(candidate, Limits::None, kPicture), (PixelBox{-1, 2, 3, 0, 4, 0.5f, 0}));
}

TEST(PixelBox, LimitsTheCornerWithoutMovingTheOtherEdge) {
  const Candidate candidate{.x = -20, .y = -10, .width = 200, .height = 40};
  EXPECT_EQ(to_pixels(candidate, Limits::Corner, kPicture), (PixelBox{0, 0, 200, 40, -1, 0, 0}));
  EXPECT_EQ(to_pixels(candidate, Limits::CornerAndSize, kPicture),
            (PixelBox{0, 0, 100, 40, -1, 0, 0}));
}

TEST(PixelBox, HugeNumbersStayInRange) {
  const float huge = std::numeric_limits<float>::max();
  const PixelBox far =
      to_pixels({.x = huge, .y = -huge, .width = huge, .height = huge}, Limits::None, kPicture);
  EXPECT_GT(int64_t{far.x} + far.width, int64_t{1} << 30);
  EXPECT_LE(int64_t{far.x} + far.width, std::numeric_limits<int32_t>::max());
}

// inter / (area + area - inter) with an inclusive intersection.
TEST(InclusiveOverlap, CountsThePixelAtTheEdge) {
  EXPECT_FLOAT_EQ(inclusive_overlap(box(0, 0, 10, 10), box(0, 0, 10, 10)), 121.f / 79);
  EXPECT_FLOAT_EQ(inclusive_overlap(box(0, 0, 10, 10), box(5, 0, 10, 10)), 66.f / 134);
  EXPECT_FLOAT_EQ(inclusive_overlap(box(0, 0, 10, 10), box(10, 10, 10, 10)), 1.f / 199);
  EXPECT_FLOAT_EQ(inclusive_overlap(box(0, 0, 10, 10), box(11, 0, 10, 10)), 0);
  EXPECT_FLOAT_EQ(inclusive_overlap(box(3, 3, 0, 0), box(3, 3, 0, 0)), 0) << "1 / -1";
}

TEST(InclusiveOverlap, TheGreatestBoxesDoNotOverflow) {
  const int32_t side = 1 << 30;
  EXPECT_GE(inclusive_overlap(box(0, 0, side, side), box(0, 0, side, side)), 1);
}

TEST(PixelSuppression, KeepsTheBestOfEachGroupInOrder) {
  const auto kept = suppress({box(0, 0, 10, 10, 0.5f), box(50, 0, 10, 10, 0.75f),
                              box(1, 1, 10, 10, 0.875f), box(50, 1, 10, 10, 0.25f)},
                             0.5f);
  EXPECT_EQ(kept, (PixelBoxes{box(1, 1, 10, 10, 0.875f), box(50, 0, 10, 10, 0.75f)}));
}

TEST(PixelSuppression, RemovesOnlyAboveTheThreshold) {
  const PixelBoxes boxes{box(0, 0, 10, 10, 0.75f), box(5, 0, 10, 10, 0.5f)};
  EXPECT_EQ(suppress(boxes, 66.f / 134).size(), 2u);
  EXPECT_EQ(suppress(boxes, 0.49f).size(), 1u);
}

TEST(PixelSuppression, DoesNotLookAtClasses) {
  PixelBoxes boxes{box(0, 0, 10, 10, 0.75f), box(0, 0, 10, 10, 0.5f)};
  boxes[1].class_index = 7;
  EXPECT_EQ(suppress(boxes, 0.5f).size(), 1u);
}

PixelBoxes random_boxes(size_t count, int32_t places, int32_t sides) {
  std::mt19937 random(static_cast<uint32_t>(count));
  std::uniform_int_distribution<int32_t> place(-places / 4, places), side(-2, sides);
  PixelBoxes boxes;
  for (size_t i = 0; i < count; ++i)
    boxes.push_back(box(place(random), place(random), side(random), side(random),
                        static_cast<float>(i * 7919 % count)));
  return boxes;
}
template <class Overlap>
PixelBoxes kept_by_plain_loop(PixelBoxes boxes, float threshold, Overlap&& overlap) {
  std::sort(boxes.begin(), boxes.end(),
            [](const auto& a, const auto& b) { return a.probability > b.probability; });
  PixelBoxes kept;
  for (const PixelBox& b : boxes) {
    bool is_kept = true;
    for (const PixelBox& a : kept) is_kept = is_kept && !(overlap(a, b) > threshold);
    if (is_kept) kept.push_back(b);
  }
  return kept;
}

// Against the definition, for few boxes and for as many as a grid is used for.
TEST(PixelSuppression, AgreesWithAPlainLoop) {
  const auto overlap = [](const PixelBox& a, const PixelBox& b) {
    const double w = std::max(0, std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x) + 1);
    const double h = std::max(0, std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y) + 1);
    const double o = w * h / (double(a.width) * a.height + double(b.width) * b.height - w * h);
    return std::max(o, 0.0);
  };
  for (const auto& [count, places, sides] :
       {std::tuple{199u, 60, 40}, {1999u, 300, 80}, {1999u, 5000, 30}, {1999u, 40000, 30000}})
    for (const float threshold : {-1.f, 0.f, 0.3f, 0.9f}) {
      const auto boxes = random_boxes(count, places, sides);
      EXPECT_EQ(suppress(boxes, threshold), kept_by_plain_loop(boxes, threshold, overlap))
          << count << " " << places << " " << threshold;
    }
}

TEST(PixelSuppression, OfManyRotatedBoxesAgreesWithAPlainLoop) {
  auto boxes = random_boxes(1499, 1000, 80);
  for (size_t i = 0; i < boxes.size(); ++i) boxes[i].angle = static_cast<float>(i % 7);
  EXPECT_EQ(suppress_rotated(boxes, 0.2f), kept_by_plain_loop(boxes, 0.2f, rotated_overlap));
}

TEST(RotatedOverlap, OfTheSameBoxIsOne) {
  for (const float angle : {0.f, 0.5f, 2.f}) {
    const PixelBox a{50, 50, 24, 12, 0, 1, angle};
    EXPECT_FLOAT_EQ(rotated_overlap(a, a), 1);
  }
}

// A cross: the points of the smaller box that lie in the larger one are the two middle columns.
TEST(RotatedOverlap, CountsTheSamplesInBoth) {
  const float quarter = std::numbers::pi_v<float> / 2;
  const PixelBox flat{50, 50, 60, 20, 0, 1, 0}, tall{50, 50, 60, 24, 0, 1, quarter};
  // 24 of 60 pixels across: samples at 5, 15, ... 55 from the left edge; 25 and 35 are within
  // 18 to 42.
  const float common = 1200 * 12 / 36.f;
  EXPECT_FLOAT_EQ(rotated_overlap(flat, tall), common / (1200 + 1440 - common));
  EXPECT_FLOAT_EQ(rotated_overlap(tall, flat), rotated_overlap(flat, tall));
}

TEST(RotatedOverlap, IsZeroForBoxesApartAndWithoutArea) {
  EXPECT_EQ(rotated_overlap({0, 0, 10, 10, 0, 1, 0}, {100, 0, 10, 10, 0, 1, 1}), 0);
  EXPECT_EQ(rotated_overlap({0, 0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 1, 0}), 0);
}

using Numbers = std::vector<uint64_t>;
std::vector<PixelBox> at(std::initializer_list<int32_t> columns) {
  std::vector<PixelBox> boxes;
  for (const int32_t x : columns) boxes.push_back(box(x, 0, 10, 10));
  return boxes;
}

TEST(CentroidTracker, NumbersBoxesInTheOrderOfTheResults) {
  CentroidTracker tracker;
  EXPECT_EQ(tracker.follow(at({50, 0, 20})), (Numbers{1, 2, 3}));
  EXPECT_EQ(tracker.follow(at({1, 22, 49})), (Numbers{2, 3, 1}));
}

TEST(CentroidTracker, TheNearestPairMatchesFirst) {
  CentroidTracker tracker;
  tracker.follow(at({0, 100}));
  EXPECT_EQ(tracker.follow(at({60, 90})), (Numbers{1, 2})) << "90 is nearer to 100 than 60";
  EXPECT_EQ(tracker.follow(at({90})), (Numbers{2}));
}

TEST(CentroidTracker, NewBoxesGetNewNumbers) {
  CentroidTracker tracker;
  tracker.follow(at({0}));
  EXPECT_EQ(tracker.follow(at({200, 1})), (Numbers{2, 1}));
}

TEST(CentroidTracker, ObjectsKeepThePlaceWhereTheyWereFirstSeen) {
  CentroidTracker tracker;
  tracker.follow(at({0, 100}));
  tracker.follow(at({40, 100}));
  tracker.follow(at({40, 60}));
  // By the last places, 60 would be object 2 and 40 object 1, as here; 52 is nearer to 100 than to
  // 0 but nearer to 40 than to 60.
  EXPECT_EQ(tracker.follow(at({52})), (Numbers{2}));
}

TEST(CentroidTracker, AnObjectIsForgottenAfterAHundredFrames) {
  for (const auto& [frames, number] : {std::pair{99, 1u}, {100, 2u}}) {
    CentroidTracker tracker;
    tracker.follow(at({0}));
    for (int i = 0; i < frames; ++i) tracker.follow({});
    EXPECT_EQ(tracker.follow(at({0})), (Numbers{number})) << frames;
  }
}

TEST(CentroidTracker, FollowsAHundredObjects) {
  CentroidTracker tracker;
  std::vector<PixelBox> boxes;
  for (int i = 0; i < 150; ++i) boxes.push_back(box(i * 20, 0, 10, 10));
  const auto numbers = tracker.follow(boxes);
  EXPECT_EQ(numbers[99], 100u);
  EXPECT_EQ(numbers[100], 0u);
  EXPECT_EQ(tracker.follow(boxes), numbers);
}

TEST(CentroidTracker, BeginsAgainAfterAReset) {
  CentroidTracker tracker;
  tracker.follow(at({0, 50}));
  tracker.reset();
  EXPECT_EQ(tracker.follow(at({50})), (Numbers{1}));
}

}  // namespace boxes_test
}  // namespace weir::detection
