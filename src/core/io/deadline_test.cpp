// Tests deadlines that are near, past and beyond the range of the clock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/io/deadline.hpp"

#include <gtest/gtest.h>

namespace weir::io {
namespace deadline_test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

const Clock::time_point kNow{1h};

TEST(PollTimeout, IsUnlimitedWithoutADeadlineOnly) {
  EXPECT_EQ(poll_timeout(std::nullopt, kNow), -1);
  EXPECT_EQ(poll_timeout(kNow, kNow), 0);
  for (const auto late : {1ns, 1'000'000ns, 1'500'000ns, 3'600'000'000'000ns})
    EXPECT_EQ(poll_timeout(kNow - late, kNow), 0) << late.count() << " ns late";
  EXPECT_EQ(poll_timeout(Clock::time_point::min() + 2h, kNow), 0);
}

TEST(PollTimeout, IsRoundedUp) {
  EXPECT_EQ(poll_timeout(kNow + 1ns, kNow), 1);
  EXPECT_EQ(poll_timeout(kNow + 10ms, kNow), 10);
  EXPECT_EQ(poll_timeout(kNow + 10ms + 1ns, kNow), 11);
}

TEST(PollTimeout, IsCutWhereAnIntEnds) {
  EXPECT_EQ(poll_timeout(kNow + milliseconds(int64_t{INT_MAX}), kNow), INT_MAX);
  EXPECT_EQ(poll_timeout(kNow + milliseconds(int64_t{INT_MAX} + 1), kNow), INT_MAX);
  EXPECT_EQ(poll_timeout(Clock::time_point::max(), kNow), INT_MAX);
}

TEST(DeadlineIn, IsNoneBeyondTheClock) {
  EXPECT_EQ(deadline_in(10ms, 3, kNow), kNow + 30ms);
  EXPECT_EQ(deadline_in(milliseconds(UINT32_MAX), 10, kNow),
            kNow + milliseconds(10 * int64_t{UINT32_MAX}))
      << "the longest isolate-timeout";
  EXPECT_EQ(deadline_in(milliseconds::max(), 1, kNow), std::nullopt);
  EXPECT_EQ(deadline_in(milliseconds::max() / 5, 10, kNow), std::nullopt) << "no overflow";
  const auto max = std::chrono::floor<milliseconds>(Clock::time_point::max() - kNow);
  EXPECT_EQ(deadline_in(max, 1, kNow), kNow + max);
  EXPECT_EQ(deadline_in(max + 1ms, 1, kNow), std::nullopt);
}

TEST(Earlier, NoDeadlineIsAfterAll) {
  EXPECT_EQ(earlier(kNow, kNow + 1ms), kNow);
  EXPECT_EQ(earlier(kNow + 1ms, kNow), kNow);
  EXPECT_EQ(earlier(kNow, std::nullopt), kNow);
  EXPECT_EQ(earlier(std::nullopt, kNow), kNow);
  EXPECT_EQ(earlier(std::nullopt, std::nullopt), std::nullopt);
}

TEST(IsOver, HoldsFromTheDeadlineOn) {
  EXPECT_FALSE(is_over(std::nullopt));
  EXPECT_TRUE(is_over(Clock::now()));
  EXPECT_FALSE(is_over(Clock::time_point::max()));
}

}  // namespace deadline_test
}  // namespace weir::io
