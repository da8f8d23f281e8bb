// Tests of the tracker: numbers that stay with objects, and input that must not confuse it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/track/assignment.hpp"

namespace weir::track {
namespace tracker_test {

Observation at(float x, float y, float score = 0.9f, int64_t group = 0) {
  return {{x, y, x + 40, y + 80}, score, group};
}
using Boxes = std::vector<Observation>;
using Numbers = std::vector<uint32_t>;

TEST(Assignment, TakesTheLeastSumNotTheLeastPair) {
  const std::vector<PairCost> all{{0, 0, 0.1f}, {0, 1, 0.2f}, {1, 0, 0.3f}, {1, 1, 0.9f}};
  float sum = 0;
  for (const auto& pair : assign(all)) sum += pair.cost;
  EXPECT_FLOAT_EQ(sum, 0.5f);  // 0-1 and 1-0; greedy takes 0-0 and 1-1, 1.0
}

TEST(Assignment, IsTheBestOfAllPermutations) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> cost(0, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<PairCost> all;
    float costs[5][5];
    for (uint32_t i = 0; i < 5; ++i)
      for (uint32_t j = 0; j < 5; ++j) all.push_back({i, j, costs[i][j] = cost(random)});
    float sum = 0;
    for (const auto& pair : assign(all)) sum += pair.cost - 1;
    int order[] = {0, 1, 2, 3, 4};
    float best = 0;
    do {
      float other = 0;
      for (int i = 0; i < 5; ++i) other += costs[i][order[i]] - 1;
      best = std::min(best, other);
    } while (std::next_permutation(order, order + 5));
    EXPECT_NEAR(sum, best, 1e-4f);
  }
}

// Leaving a row without a pair costs 1, as a column of its own does.
double best_cost(const std::vector<PairCost>& all, uint32_t rows, uint32_t columns) {
  Matrix gains(rows, size_t{columns} + rows);
  for (size_t r = 0; r < rows; ++r)
    for (size_t c = 0; c < size_t{columns} + rows; ++c)
      gains.at(r, c) = c == columns + r ? -1 : -99;
  for (const auto& pair : all) gains.at(pair.row, pair.column) = -double{pair.cost};
  const auto column_of = best_assignment(gains);
  double sum = 0;
  for (size_t r = 0; r < rows; ++r) sum -= gains.at(r, column_of[r].value());
  return sum;
}

TEST(Assignment, OfSomeOfAllPairsIsAsGoodAsThatOfAMatrix) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> cost(0, 1);
  for (const auto& [rows, columns] : {std::pair{40u, 40u}, {60u, 7u}, {7u, 60u}, {300u, 20u}})
    for (int percent : {5, 20, 100}) {
      std::vector<PairCost> all;
      for (uint32_t i = 0; i < rows; ++i)
        for (uint32_t j = 0; j < columns; ++j)
          if (static_cast<int>(random() % 100) < percent) all.push_back({i, j, cost(random)});
      double sum = rows;
      std::vector<uint32_t> used_rows, used_columns;
      for (const auto& pair : assign(all)) {
        sum += double{pair.cost} - 1;
        used_rows.push_back(pair.row), used_columns.push_back(pair.column);
      }
      EXPECT_NEAR(sum, best_cost(all, rows, columns), 1e-4) << rows << 'x' << columns;
      for (auto* used : {&used_rows, &used_columns}) {
        std::sort(used->begin(), used->end());
        EXPECT_EQ(std::adjacent_find(used->begin(), used->end()), used->end());
      }
    }
}

TEST(Tracker, NumbersStayThroughACrossing) {
  Tracker tracker;
  Numbers first;
  for (int i = 0; i < 40; ++i) {
    const float step = static_cast<float>(i) * 6;
    const auto numbers = tracker.follow(Boxes{at(step, 100), at(240 - step, 110)}, i / 30.0, {});
    if (i == 1) first = numbers;
    if (i > 1) {
      EXPECT_EQ(numbers, first) << i;
    }
  }
  EXPECT_EQ(first, (Numbers{1, 2}));
}

TEST(Tracker, ANumberReturnsAfterAGap) {
  Tracker tracker;
  for (int i = 0; i < 30; ++i) {
    const bool is_hidden = i >= 15 && i < 25;
    const auto x = static_cast<float>(i) * 5;
    const auto numbers = tracker.follow(is_hidden ? Boxes{} : Boxes{at(x, 0)}, i / 30.0, {});
    if (!is_hidden && i > 0) {
      EXPECT_EQ(numbers, Numbers{1}) << i;
    }
  }
}

TEST(Tracker, TheIouModeLosesThatObject) {
  Tracker tracker;
  Numbers last;
  for (int i = 0; i < 30; ++i) {
    const bool is_hidden = i >= 15 && i < 25;
    const auto x = static_cast<float>(i) * 5;
    last = tracker.follow(is_hidden ? Boxes{} : Boxes{at(x, 0)}, i / 30.0, {.mode = Mode::Iou});
  }
  EXPECT_EQ(last, Numbers{2});
}

// A camera that jumps 30 pixels to and fro, more than half of the boxes' width.
Numbers numbers_of_a_jump(const Options& options) {
  Tracker tracker;
  Numbers last;
  for (int i = 0; i < 20; ++i) {
    const float jump = i % 2 ? 30.f : 0.f;
    Boxes boxes;
    for (int k = 0; k < 6; ++k) boxes.push_back(at(static_cast<float>(k) * 45 + jump, 20));
    last = tracker.follow(boxes, i / 30.0, options);
  }
  return last;
}

TEST(Tracker, TheMotionOfTheCameraChangesNoNumbers) {
  EXPECT_EQ(numbers_of_a_jump({}), (Numbers{1, 2, 3, 4, 5, 6}));
  EXPECT_NE(numbers_of_a_jump({.camera_motion = false}), (Numbers{1, 2, 3, 4, 5, 6}));
}

TEST(Tracker, ALostTrackMovesWithTheCamera) {
  Tracker tracker;
  Numbers last;
  for (int i = 0; i < 20; ++i) {
    const float pan =
        i < 8 ? 0 : static_cast<float>(i - 8) * 15;  // the last one is hidden meanwhile
    Boxes boxes;
    for (int k = 0; k < (i >= 8 && i < 16 ? 5 : 6); ++k)
      boxes.push_back(at(static_cast<float>(k) * 100 + pan, 20));
    last = tracker.follow(boxes, i / 30.0, {});
  }
  EXPECT_EQ(last, (Numbers{1, 2, 3, 4, 5, 6}));
}

// A box half as high in the place of one that was lost, such as that of a person behind it.
TEST(Tracker, ALostTrackTakesNoBoxOfAnotherHeight) {
  const Observation half{{0, 0, 40, 40}, 0.9f, 0};
  for (const Mode mode : {Mode::ByteTrack, Mode::Iou}) {
    Tracker tracker;
    const Options options{.mode = mode, .min_hits = 1};
    tracker.follow(Boxes{at(0, 0)}, 0, options);
    tracker.follow(Boxes{}, 0.1, options);
    const bool is_other = mode == Mode::ByteTrack;
    EXPECT_EQ(tracker.follow(Boxes{half}, 0.2, options), Numbers{is_other ? 2u : 1u});
  }
  Tracker tracker;  // one that was not lost may change its height: the detector saw its upper half
  tracker.follow(Boxes{at(0, 0)}, 0, {.min_hits = 1});
  EXPECT_EQ(tracker.follow(Boxes{half}, 0.1, {.min_hits = 1}), Numbers{1});
}

TEST(Tracker, LowScoresContinueTracksAndBeginNone) {
  Tracker tracker;
  tracker.follow(Boxes{at(0, 0)}, 0, {});
  tracker.follow(Boxes{at(0, 0)}, 0.1, {});
  EXPECT_EQ(tracker.follow(Boxes{at(1, 0, 0.2f), at(500, 0, 0.2f)}, 0.2, {}), (Numbers{1, 0}));
  EXPECT_EQ(tracker.follow(Boxes{at(1, 0, 0.2f), at(500, 0, 0.2f)}, 0.3, {}), (Numbers{1, 0}));
  EXPECT_EQ(tracker.follow(Boxes{at(1, 0, 0.05f)}, 0.4, {}), Numbers{0});
}

TEST(Tracker, GroupsAreDifferentObjects) {
  Tracker tracker;
  tracker.follow(Boxes{at(0, 0)}, 0, {.min_hits = 1});
  EXPECT_EQ(tracker.follow(Boxes{at(0, 0, 0.9f, 1)}, 0.1, {.min_hits = 1}), Numbers{2});
}

TEST(Tracker, TimeThatGoesBackOrJumpsForgetsTracks) {
  Tracker tracker;
  const Options at_once{.min_hits = 1};
  EXPECT_EQ(tracker.follow(Boxes{at(0, 0)}, 5, at_once), Numbers{1});
  EXPECT_EQ(tracker.follow(Boxes{at(0, 0)}, 5, at_once), Numbers{1});  // repeats
  EXPECT_EQ(tracker.follow(Boxes{at(0, 0)}, 4, at_once), Numbers{2});
  EXPECT_EQ(tracker.follow(Boxes{at(0, 0)}, 5.1, at_once), Numbers{3});  // beyond max_age
}

TEST(Tracker, BoxesThatAreNoneHaveNoNumber) {
  Tracker tracker;
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  const Boxes bad{{{nan, 0, 9, 9}}, {{0, 0, inf, 9}}, {{9, 9, 0, 0}}, {{0, 0, 9, 9}, nan}};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(tracker.follow(bad, i, {.min_hits = 1}), Numbers(4, 0));
  EXPECT_EQ(tracker.tracks(), 0u);
}

TEST(Tracker, TenThousandBoxesAreFollowed) {
  Tracker tracker;
  Boxes boxes;
  for (int i = 0; i < 10000; ++i)
    boxes.push_back(at(static_cast<float>(i % 100) * 50, static_cast<float>(i / 100) * 90));
  const Options at_once{.min_hits = 1};
  const Numbers first = tracker.follow(boxes, 0, at_once);
  EXPECT_EQ(tracker.follow(boxes, 0.03, at_once), first);
}

// Of boxes of one size, moved by up to `spread` pixels.
Boxes crowd(size_t count, float spread, std::mt19937* random) {
  std::uniform_real_distribution<float> place(0, spread);
  Boxes out;
  for (size_t i = 0; i < count; ++i) {
    const float x = place(*random), y = place(*random);
    out.push_back({{x, y, x + 100, y + 100}});
  }
  return out;
}

// Frames may come from another machine.
TEST(Tracker, ACrowdOfOverlappingBoxesIsComparedInProportionToItsBoxes) {
  constexpr size_t kBoxes = 3000, kTimes = 2;  // a track is matched once or twice
  std::mt19937 random(4);
  for (const float spread : {0.0f, 30.0f}) {
    Tracker tracker;
    const Boxes boxes = crowd(kBoxes, spread, &random);
    for (size_t frame = 0; frame < 3; ++frame) {
      tracker.follow(boxes, static_cast<double>(frame) / 30, {});
      EXPECT_LE(tracker.compared(), kTimes * Tracker::kMaxCompared * kBoxes) << spread;
      EXPECT_LE(tracker.candidates(), kTimes * Tracker::kMaxCandidates * kBoxes) << spread;
    }
    EXPECT_GE(tracker.compared(), kBoxes) << spread;
    EXPECT_GE(tracker.candidates(), kBoxes) << spread;
  }
}

TEST(Tracker, ACrowdWithAppearancesIsComparedInProportionToItsBoxes) {
  constexpr size_t kBoxes = 4000;
  const std::vector<float> look{1, 0};
  Tracker tracker;
  Boxes boxes;
  for (const float x : {0.0f, 1e6f}) {  // no box overlaps one of the first frame
    boxes.assign(kBoxes, at(x, 0));
    for (auto& box : boxes) box.appearance = look;
    tracker.follow(boxes, x / 1e8, {.camera_motion = false, .min_hits = 1});
  }
  EXPECT_LE(tracker.compared(), Tracker::kMaxCompared * kBoxes);
  EXPECT_GE(tracker.compared(), kBoxes) << "no appearance was compared";
}

TEST(Tracker, NumbersStayInACrowdOfOverlappingBoxes) {
  Tracker tracker;
  std::mt19937 random(5);
  const Boxes boxes = crowd(1000, 40, &random);
  const Numbers first = tracker.follow(boxes, 0, {.min_hits = 1});
  EXPECT_EQ(tracker.follow(boxes, 1 / 30.0, {.min_hits = 1}), first);
}

TEST(Tracker, BoxesBeyondTheLimitHaveNoNumber) {
  Tracker tracker;
  std::mt19937 random(6);
  Boxes boxes = crowd(3 * Tracker::kBoxLimit, 40, &random);
  for (size_t i = 0; i < boxes.size(); ++i) boxes[i].score = i % 3 == 1 ? 0.9f : 0.6f;
  boxes.push_back(at(0, 0, 0.01f));  // is below `low`
  const Numbers& numbers = tracker.follow(boxes, 0, {.min_hits = 1});
  EXPECT_EQ(tracker.left_out(), 2 * Tracker::kBoxLimit);
  EXPECT_EQ(tracker.tracks(), Tracker::kBoxLimit);
  for (size_t i = 0; i < boxes.size(); ++i) ASSERT_EQ(numbers[i] != 0, i % 3 == 1) << i;
  tracker.follow(Boxes{at(0, 0)}, 1, {});
  EXPECT_EQ(tracker.left_out(), 0u);
}

TEST(Tracker, ChurnLeavesABoundedNumberOfTracks) {
  Tracker tracker;
  std::mt19937 random(2);
  std::uniform_real_distribution<float> place(0, 100000);
  for (int i = 0; i < 200; ++i) {
    Boxes boxes;
    for (int k = 0; k < 200; ++k) boxes.push_back(at(place(random), place(random)));
    tracker.follow(boxes, i / 30.0, {.max_age = 1000, .min_hits = 1});
    EXPECT_LE(tracker.tracks(), Tracker::kLostLimit + 200);
  }
}

}  // namespace tracker_test
}  // namespace weir::track
