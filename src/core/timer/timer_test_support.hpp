// Test helper: a timer queue with a clock that the test controls.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include "core/timer/timer_queue.hpp"

namespace weir {

class TimersTest : public ::testing::Test {
 protected:
  void advance(TimerQueue::Clock::duration by) {
    now_ += by;
    queue_.run_due();
  }
  TimerQueue::Clock::time_point now_{std::chrono::hours(1)};
  TimerQueue queue_{[this] { return now_; }};
};

}  // namespace weir
