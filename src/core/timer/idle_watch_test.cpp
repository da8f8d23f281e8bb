// When on_idle is called.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/timer/idle_watch.hpp"

#include "core/timer/timer_test_support.hpp"

namespace weir {
namespace idle_watch_test {

using namespace std::chrono_literals;

class IdleWatchTest : public TimersTest {
 protected:
  int calls_ = 0;
  bool ready_ = true;
  IdleWatch watch_{queue_, 100ms, [this] {
                     ++calls_;
                     return ready_;
                   }};
};

TEST_F(IdleWatchTest, FiresOnceAfterTheLimitAndAgainAfterTheNextTouch) {
  advance(99ms);
  EXPECT_EQ(calls_, 0);
  advance(1ms);
  EXPECT_EQ(calls_, 1);
  advance(1h);
  EXPECT_EQ(calls_, 1) << "nothing is watched while it is idle";
  EXPECT_FALSE(queue_.next());
  watch_.touch();
  advance(99ms);
  EXPECT_EQ(calls_, 1);
  advance(1ms);
  EXPECT_EQ(calls_, 2);
}

TEST_F(IdleWatchTest, CountsFromTheLastTouch) {
  for (int i = 0; i < 10; ++i) {
    advance(60ms);
    watch_.touch();
  }
  EXPECT_EQ(calls_, 0);
  advance(99ms);
  EXPECT_EQ(calls_, 0);
  advance(1ms);
  EXPECT_EQ(calls_, 1);
}

TEST_F(IdleWatchTest, RetriesIfTheCallbackIsBusy) {
  ready_ = false;
  advance(100ms);
  advance(100ms);
  EXPECT_EQ(calls_, 2);
  ready_ = true;
  advance(100ms);
  advance(1h);
  EXPECT_EQ(calls_, 3);
}

TEST_F(IdleWatchTest, NoticesATouchDuringTheCallback) {
  IdleWatch own(queue_, 100ms, [&, first = true]() mutable {
    if (std::exchange(first, false)) {
      now_ += 1ms;
      own.touch();
    }
    ++calls_;
    return true;
  });
  advance(100ms);
  const int after = calls_;
  advance(100ms);
  EXPECT_EQ(calls_, after + 1);
}

}  // namespace idle_watch_test
}  // namespace weir
