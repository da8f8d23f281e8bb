// Detection and error text of times that go backwards.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/backwards_time.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace backwards_time_test {

TEST(BackwardsTime, IsReportedOnce) {
  BackwardsTimeWatch watch;
  for (const uint64_t time : {0u, 5u, 5u, 9u})
    EXPECT_EQ(watch.check(time, OnBackwardsTime::Pass), std::nullopt) << time;
  EXPECT_EQ(watch.check(8, OnBackwardsTime::Pass), 9u);
  EXPECT_EQ(watch.check(8, OnBackwardsTime::Pass), std::nullopt)
      << "8 passed: it counts from there";
}

TEST(BackwardsTime, DroppedFramesAreNotComparedWith) {
  BackwardsTimeWatch watch;
  EXPECT_EQ(watch.check(9, OnBackwardsTime::Drop), std::nullopt);
  EXPECT_EQ(watch.check(3, OnBackwardsTime::Drop), 9u);
  EXPECT_EQ(watch.check(8, OnBackwardsTime::Drop), 9u) << "still before the last that passed";
  EXPECT_EQ(watch.check(9, OnBackwardsTime::Drop), std::nullopt);
}

TEST(BackwardsTime, CanBeReset) {
  BackwardsTimeWatch watch;
  EXPECT_EQ(watch.check(9, OnBackwardsTime::Drop), std::nullopt);
  watch.reset();
  EXPECT_EQ(watch.check(0, OnBackwardsTime::Drop), std::nullopt);
}

TEST(BackwardsTime, IsReportedWithBothTimesAndTheProperty) {
  const auto passed = backwards_time(1'500'000'000, 3'723'000'000'001, OnBackwardsTime::Pass);
  EXPECT_EQ(passed.code, Code::TIME_INVALID);
  EXPECT_EQ(passed.what, "a timestamp goes backwards; these frames are counted and passed on");
  EXPECT_EQ(passed.offered, "0:00:01.500000000");
  EXPECT_EQ(passed.needed, "at least 1:02:03.000000001, the previous timestamp");
  EXPECT_EQ(passed.fix, "on-backwards-time=drop, to drop these frames");
  const auto dropped = backwards_time(0, 1, OnBackwardsTime::Drop);
  EXPECT_SAYS(dropped.what, "dropped and counted");
  EXPECT_SAYS(dropped.fix, "on-backwards-time=pass");
}

}  // namespace backwards_time_test
}  // namespace weir
