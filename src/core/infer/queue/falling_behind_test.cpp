// Tests streams that fall behind, catch up, or have a constant lag.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/falling_behind.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace weir::infer {
namespace falling_behind_test {

using std::chrono::milliseconds;

// The time of the frame that triggers detection; -1 = none within a minute of a frame per 100 ms.
int reported_at(const std::function<int(int)>& lag_of) {
  FallingBehind watch;
  for (int now = 0; now < 60000; now += 100)
    if (watch.observe(milliseconds(now), milliseconds(lag_of(now)))) return now;
  return -1;
}

TEST(FallingBehind, ReportsAStreamWithGrowingDelay) {
  EXPECT_EQ(reported_at([](int now) { return now / 2; }), 4000) << "a second late at 2000";
}

TEST(FallingBehind, ReportsAStreamThatStaysLate) {
  EXPECT_EQ(reported_at([](int) { return 1000; }), 2000);
}

TEST(FallingBehind, IgnoresAStreamThatIsOnTime) {
  EXPECT_EQ(reported_at([](int now) { return now % 900; }), -1);
  EXPECT_EQ(reported_at([](int) { return -5000; }), -1) << "ahead of its time";
}

TEST(FallingBehind, IgnoresASlowStartThatCatchesUp) {
  EXPECT_EQ(reported_at([](int now) { return 8000 - now; }), -1);
}

TEST(FallingBehind, IgnoresASinglePause) {
  EXPECT_EQ(reported_at([](int now) { return now % 3000 < 1900 ? 5000 : 0; }), -1);
}

TEST(FallingBehind, StartsAgainAfterAReset) {
  FallingBehind watch;
  EXPECT_FALSE(watch.observe(milliseconds(0), milliseconds(1500)));
  watch.reset();
  EXPECT_FALSE(watch.observe(milliseconds(2500), milliseconds(1500)));
  EXPECT_TRUE(watch.observe(milliseconds(4500), milliseconds(1500)));
}

// A camera that froze sends on with the same lag: the model waits for each frame.
TEST(FallingBehind, IgnoresALagThatIsOfTheSource) {
  FallingBehind lag;
  bool behind = false;
  for (int i = 0; i < 200; ++i)
    behind |= lag.observe(milliseconds(40 * i), std::chrono::seconds(8), milliseconds(30));
  EXPECT_FALSE(behind);
  for (int i = 200; i < 400; ++i)
    behind |= lag.observe(milliseconds(40 * i), std::chrono::seconds(8), milliseconds(1));
  EXPECT_TRUE(behind);
}

}  // namespace falling_behind_test
}  // namespace weir::infer
