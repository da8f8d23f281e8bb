// Levels from input and output, and their correction by samples.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/queue_level.hpp"

#include <gtest/gtest.h>

namespace weir::trace {
namespace queue_level_test {

std::vector<uint64_t> frames(const QueueLevel& level) {
  std::vector<uint64_t> out;
  for (const auto& step : level.steps) out.push_back(step.frames);
  return out;
}

TEST(TraceQueueLevel, IsArrivalsMinusDepartures) {
  // In any order, because threads are read one after the other.
  const QueueLevel level = queue_level({{40, -1}, {10, 1}, {20, 1}, {30, 3}}, 50);
  EXPECT_EQ(frames(level), (std::vector<uint64_t>{1, 2, 5, 4}));
  EXPECT_EQ(level.max, 5u);
  EXPECT_DOUBLE_EQ(level.mean, (1 + 2 + 5 + 4) * 10 / 40.0);
}

TEST(TraceQueueLevel, ASampleCorrectsIt) {
  // Two of five frames leaked.
  const QueueLevel level = queue_level({{1, 5}, {2, 3, true}, {3, -1}}, 3);
  EXPECT_EQ(frames(level), (std::vector<uint64_t>{5, 3, 2}));
}

TEST(TraceQueueLevel, ASampleSeesThePushOfItsOwnMoment) {
  const QueueLevel level = queue_level({{1, 4, true}, {1, 1}, {2, 4, true}, {2, 1}, {3, -1}}, 3);
  EXPECT_EQ(frames(level), (std::vector<uint64_t>{4, 4, 3}));
  EXPECT_EQ(level.max, 4u);
}

TEST(TraceQueueLevel, AFrameMayLeaveBeforeItsPushReturned) {
  EXPECT_EQ(frames(queue_level({{1, -1}, {2, 1}, {3, 1}}, 3)), (std::vector<uint64_t>{0, 0, 1}));
}

TEST(TraceQueueLevel, IsEmptyWithoutRecords) {
  const QueueLevel level = queue_level({}, 100);
  EXPECT_TRUE(level.steps.empty());
  EXPECT_EQ(level.mean, 0);
  EXPECT_EQ(highest_levels(level, 0, 100, 3), (std::vector<uint64_t>{0, 0, 0}));
}

TEST(TraceQueueLevel, APartShowsItsHighestLevelOrTheOneFromBefore) {
  const QueueLevel level = queue_level({{5, 2}, {6, 7}, {7, -8}, {40, -1}}, 40);
  EXPECT_EQ(highest_levels(level, 0, 40, 4), (std::vector<uint64_t>{9, 1, 1, 1}));
  EXPECT_EQ(highest_levels(level, 0, 0, 2), (std::vector<uint64_t>{0, 0}));
}

}  // namespace queue_level_test
}  // namespace weir::trace
