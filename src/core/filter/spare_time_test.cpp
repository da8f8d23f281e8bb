// How much of a frame's time is kept for the second model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/spare_time.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace spare_time_test {

TEST(SpareTime, KeepsATenthOfTheTimeThatIsLeft) {
  const SpareTime spare;
  EXPECT_EQ(spare.latest_end(1100, 100), 1000);
  EXPECT_TRUE(spare.is_enough(1100, 1100));
  EXPECT_FALSE(spare.is_enough(1100, 1101));
}

TEST(SpareTime, KeepsTwiceTheLongestTime) {
  SpareTime spare;
  for (const int64_t took : {100, 200, 50}) spare.add(took);
  EXPECT_EQ(spare.latest_end(1100, 100), 700);
  EXPECT_TRUE(spare.is_enough(1100, 900));
  EXPECT_FALSE(spare.is_enough(1100, 901));
}

TEST(SpareTime, LeavesAllToTheFirstModelWhereBothHaveNoTime) {
  SpareTime spare;
  spare.add(500);
  EXPECT_EQ(spare.latest_end(1100, 100), 1100);
  EXPECT_EQ(spare.latest_end(1100, 2000), 1100) << "it has expired";
}

TEST(SpareTime, ForgetsOldTimes) {
  SpareTime spare;
  spare.add(1000);
  for (size_t i = 0; i < SpareTime::kKept; ++i) spare.add(10);
  EXPECT_EQ(spare.latest_end(1100, 1000), 1080);
}

TEST(SpareTime, HasNoLimitForFramesThatDoNotExpire) {
  SpareTime spare;
  spare.add(1000);
  EXPECT_EQ(spare.latest_end(0, 5000), 0);
  EXPECT_TRUE(spare.is_enough(0, 5000));
}

}  // namespace spare_time_test
}  // namespace weir
