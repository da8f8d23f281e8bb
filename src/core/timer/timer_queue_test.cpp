// Timers with a clock that the test controls, and the process's timer thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/timer/timer_queue.hpp"

#include <future>

#include "core/timer/timer_test_support.hpp"

namespace weir {
namespace timer_queue_test {

using namespace std::chrono_literals;

class TimerQueueTest : public TimersTest {};

TEST_F(TimerQueueTest, CallsOnceWhenTheTimeHasCome) {
  int calls = 0;
  TimerQueue::Timer timer(queue_, [&] { ++calls; });
  advance(1h);
  EXPECT_EQ(calls, 0) << "it was not started";
  timer.start(100ms);
  EXPECT_EQ(queue_.next(), now_ + 100ms);
  advance(99ms);
  EXPECT_EQ(calls, 0);
  advance(1ms);
  EXPECT_EQ(calls, 1);
  advance(1h);
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(queue_.next());
}

TEST_F(TimerQueueTest, StartsAgainFromWithinAndStops) {
  int calls = 0;
  TimerQueue::Timer timer(queue_, [&] {
    if (++calls < 3) timer.start(10ms);
  });
  timer.start(10ms);
  for (int i = 0; i < 5; ++i) advance(10ms);
  EXPECT_EQ(calls, 3);
  timer.start(10ms);
  timer.stop();
  advance(1h);
  EXPECT_EQ(calls, 3);
}

TEST_F(TimerQueueTest, ALaterStartReplacesTheEarlierOne) {
  int calls = 0;
  TimerQueue::Timer timer(queue_, [&] { ++calls; });
  timer.start(10ms);
  timer.start(100ms);
  advance(50ms);
  EXPECT_EQ(calls, 0);
  advance(50ms);
  EXPECT_EQ(calls, 1);
}

TEST_F(TimerQueueTest, ACallMayEndAnotherTimer) {
  int calls = 0;
  auto second = std::make_unique<TimerQueue::Timer>(queue_, [&] { ++calls; });
  TimerQueue::Timer first(queue_, [&] { second.reset(); });
  first.start(1ms);
  second->start(2ms);
  advance(1ms);
  advance(1ms);
  EXPECT_EQ(calls, 0);
}

TEST(TimerQueueThread, CallsAtTheEarliestTimeFirst) {
  std::promise<void> late, early;
  TimerQueue::Timer second(TimerQueue::instance(), [&] { late.set_value(); });
  TimerQueue::Timer first(TimerQueue::instance(), [&] { early.set_value(); });
  second.start(1h);
  first.start(1ms);
  early.get_future().wait();
  second.start(0ms);
  late.get_future().wait();
}

TEST(TimerQueueThread, ATimerThatEndsWaitsForItsCall) {
  std::promise<void> begun, go_on;
  bool done = false;
  auto timer = std::make_unique<TimerQueue::Timer>(TimerQueue::instance(), [&] {
    begun.set_value();
    go_on.get_future().wait();
    done = true;
  });
  timer->start(0ms);
  begun.get_future().wait();
  std::thread ends([&] { timer.reset(); });
  go_on.set_value();
  ends.join();
  EXPECT_TRUE(done);
}

}  // namespace timer_queue_test
}  // namespace weir
