// How much of a frame's time is kept for the second model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/fallback_budget.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace fallback_budget_test {

TEST(FallbackBudget, KeepsATenthOfTheTimeThatIsLeft) {
  const FallbackBudget spare;
  EXPECT_EQ(spare.latest_end(1100, 100), 1000);
  EXPECT_TRUE(spare.is_enough(1100, 1100));
  EXPECT_FALSE(spare.is_enough(1100, 1101));
}

TEST(FallbackBudget, KeepsTwiceTheLongestTime) {
  FallbackBudget spare;
  for (const int64_t took : {100, 200, 50}) spare.add(took);
  EXPECT_EQ(spare.latest_end(1100, 100), 700);
  EXPECT_TRUE(spare.is_enough(1100, 900));
  EXPECT_FALSE(spare.is_enough(1100, 901));
}

TEST(FallbackBudget, LeavesAllToTheFirstModelWhereBothHaveNoTime) {
  FallbackBudget spare;
  spare.add(500);
  EXPECT_EQ(spare.latest_end(1100, 100), 1100);
  EXPECT_EQ(spare.latest_end(1100, 2000), 1100) << "it has expired";
}

TEST(FallbackBudget, ForgetsOldTimes) {
  FallbackBudget spare;
  spare.add(1000);
  for (size_t i = 0; i < FallbackBudget::kKept; ++i) spare.add(10);
  EXPECT_EQ(spare.latest_end(1100, 1000), 1080);
}

TEST(FallbackBudget, HasNoLimitForFramesThatDoNotExpire) {
  FallbackBudget spare;
  spare.add(1000);
  EXPECT_EQ(spare.latest_end(0, 5000), 0);
  EXPECT_TRUE(spare.is_enough(0, 5000));
}

}  // namespace fallback_budget_test
}  // namespace weir
