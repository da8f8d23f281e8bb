// Tests the polling time for given waits, without a clock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/adaptive_poll.hpp"

#include <gtest/gtest.h>

namespace weir::isolate {
namespace adaptive_poll_test {

using namespace std::chrono_literals;

AdaptivePoll after(int times, AdaptivePoll::Duration wait, AdaptivePoll from = {}) {
  for (int i = 0; i < times; ++i) from.took(wait);
  return from;
}

TEST(AdaptivePoll, StartsWithTheTimeOfAWakeUp) {
  EXPECT_EQ(AdaptivePoll().poll_time(), 50us);
}

TEST(AdaptivePoll, IsPatientForTwiceTheTimeOfShortResponses) {
  const auto poll_time = after(60, 100us).poll_time();
  EXPECT_GT(poll_time, 199us);
  EXPECT_LE(poll_time, 200us);
}

TEST(AdaptivePoll, FollowsByAQuarterOfTheDifference) {
  EXPECT_EQ(after(1, 105us).poll_time(), 2 * (25us + 20us));
  EXPECT_EQ(after(2, 105us).poll_time(), 2 * (25us + 20us + 15us));
}

TEST(AdaptivePoll, SpinsForFastResponses) {
  EXPECT_EQ(after(60, 0us).poll_time(), 20us);
  EXPECT_EQ(after(60, -5us).poll_time(), 20us) << "a clock that goes back is no wait";
}

TEST(AdaptivePoll, SleepsAtOnceForSlowResponses) {
  EXPECT_EQ(after(60, 10ms).poll_time(), 0us);
  EXPECT_EQ(after(60, 210us).poll_time(), 0us);
}

TEST(AdaptivePoll, ToleratesOneLongWait) {
  const auto short_ones = after(60, 40us);
  EXPECT_GT(after(1, 10s, short_ones).poll_time(), 80us);
  EXPECT_LE(after(1, 10s, short_ones).poll_time(), 400us);
}

TEST(AdaptivePoll, RecoversWithinTenShortResponses) {
  EXPECT_GT(after(10, 30us, after(100, 10s)).poll_time(), 0us);
}

}  // namespace adaptive_poll_test
}  // namespace weir::isolate
