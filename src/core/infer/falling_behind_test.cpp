// Streams that fall behind, catch up, or are late by the same all the time.
#include "core/infer/falling_behind.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace weir::infer {
namespace {

using std::chrono::milliseconds;

// The time of the frame with which it is told; -1 = never in a minute, a frame each 100 ms.
int told_at(const std::function<int(int)>& lag_of) {
  FallingBehind watch;
  for (int now = 0; now < 60000; now += 100)
    if (watch.observe(milliseconds(now), milliseconds(lag_of(now)))) return now;
  return -1;
}

TEST(FallingBehind, TellsOfAStreamThatIsLaterAndLater) {
  EXPECT_EQ(told_at([](int now) { return now / 2; }), 4000) << "a second late at 2000";
}

TEST(FallingBehind, TellsOfAStreamThatStaysLate) {
  EXPECT_EQ(told_at([](int) { return 1000; }), 2000);
}

TEST(FallingBehind, SaysNothingOfAStreamThatIsInTime) {
  EXPECT_EQ(told_at([](int now) { return now % 900; }), -1);
  EXPECT_EQ(told_at([](int) { return -5000; }), -1) << "ahead of its time";
}

TEST(FallingBehind, SaysNothingOfASlowStartThatIsMadeUp) {
  EXPECT_EQ(told_at([](int now) { return 8000 - now; }), -1);
}

TEST(FallingBehind, SaysNothingOfOneLatePause) {
  EXPECT_EQ(told_at([](int now) { return now % 3000 < 1900 ? 5000 : 0; }), -1);
}

TEST(FallingBehind, BeginsAnewAfterAReset) {
  FallingBehind watch;
  EXPECT_FALSE(watch.observe(milliseconds(0), milliseconds(1500)));
  watch.reset();
  EXPECT_FALSE(watch.observe(milliseconds(2500), milliseconds(1500)));
  EXPECT_TRUE(watch.observe(milliseconds(4500), milliseconds(1500)));
}

}  // namespace
}  // namespace weir::infer
