// IdleWatch: calls a function when nothing has happened for a while.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <chrono>
#include <functional>

#include "core/timer/timer_queue.hpp"

namespace weir {

class IdleWatch {
 public:
  // Calls `on_idle` on the queue's thread when `limit` has passed since the last touch(), and not
  // again before the next touch(). If it returns false, because the moment is not suitable, it is
  // called again after `limit`. Starts watching immediately.
  IdleWatch(TimerQueue& queue, std::chrono::milliseconds limit, std::function<bool()> on_idle);

  // Reports activity. Any thread; cheap.
  void touch();

 private:
  void check();

  TimerQueue& queue_;
  const TimerQueue::Clock::duration limit_;
  const std::function<bool()> on_idle_;
  std::atomic<TimerQueue::Clock::duration> last_;  // since the clock's epoch
  std::atomic<bool> watching_{true};               // the timer is started or running
  TimerQueue::Timer timer_;                        // declared last, so that it is destroyed first
};

}  // namespace weir
