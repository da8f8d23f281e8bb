// Tests means against values calculated by hand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/occupancy.hpp"

#include <gtest/gtest.h>

namespace weir::infer {
namespace occupancy_test {

Occupancy::Time at(int milliseconds) {
  return Occupancy::Time(std::chrono::milliseconds(1000 + milliseconds));
}

TEST(Occupancy, IsNothingBeforeTheFirstJob) {
  const Occupancy none;
  EXPECT_EQ(none.mean(at(50)), 0);
  EXPECT_EQ(none.busy(), 0u);
}

TEST(Occupancy, AddsUpTheTimeOfAllWorkers) {
  Occupancy o;
  o.begin(at(0));
  o.begin(at(10));
  o.end(at(20));
  o.end(at(40));
  EXPECT_EQ(o.busy(), 0u);
  EXPECT_DOUBLE_EQ(o.mean(at(40)), (10 + 2 * 10 + 20) / 40.0);
  EXPECT_DOUBLE_EQ(o.mean(at(100)), 50 / 100.0) << "idle since";
}

TEST(Occupancy, CountsFramesInProgress) {
  Occupancy o;
  o.begin(at(0));
  EXPECT_DOUBLE_EQ(o.mean(at(0)), 1);
  EXPECT_DOUBLE_EQ(o.mean(at(30)), 1);
  o.begin(at(30));
  EXPECT_DOUBLE_EQ(o.mean(at(60)), (30 + 60) / 60.0);
}

}  // namespace occupancy_test
}  // namespace weir::infer
