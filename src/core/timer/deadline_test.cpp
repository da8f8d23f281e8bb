// Deadlines within and beyond the clock's range.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/timer/deadline.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace deadline_test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
constexpr Clock::time_point kNow(1'000'000'000'000ns);

TEST(DeadlineAfter, AddsWhatIsInRange) {
  EXPECT_EQ(deadline_after(kNow, 5ns), kNow + 5ns);
  EXPECT_EQ(deadline_after(kNow, 0ns), kNow);
  EXPECT_EQ(deadline_after(kNow, -5ns), kNow - 5ns);
  EXPECT_EQ(deadline_after(Clock::time_point(-7ns), 5ns), Clock::time_point(-2ns));
  EXPECT_EQ(deadline_after(kNow, Clock::time_point::max() - kNow), Clock::time_point::max());
}

TEST(DeadlineAfter, StopsAtTheEndOfTheClock) {
  for (const auto delay : {std::chrono::nanoseconds::max(), std::chrono::nanoseconds::max() - 1ns,
                           Clock::time_point::max() - kNow + 1ns})
    EXPECT_EQ(deadline_after(kNow, delay), Clock::time_point::max()) << delay.count();
  EXPECT_EQ(deadline_after(Clock::time_point::max(), 1ns), Clock::time_point::max());
}

}  // namespace deadline_test
}  // namespace weir
