// IdleWatch: tells when nothing has happened for a while.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <chrono>
#include <functional>

#include "core/timer/timer_queue.hpp"

namespace weir {

class IdleWatch {
 public:
  // Calls `on_idle` on the queue's thread once `limit` has gone since the last touch(), and not
  // again before the next touch(). It returns false when this is no good moment: it is asked again
  // after `limit`. Watches from now on.
  IdleWatch(TimerQueue& queue, std::chrono::milliseconds limit, std::function<bool()> on_idle);

  // Something happens now. Any thread; cheap.
  void touch();

 private:
  void check();

  TimerQueue& queue_;
  const TimerQueue::Clock::duration limit_;
  const std::function<bool()> on_idle_;
  std::atomic<TimerQueue::Clock::duration> last_;  // since the clock's epoch
  std::atomic<bool> watching_{true};               // the timer is started or running
  TimerQueue::Timer timer_;                        // last: it ends first
};

}  // namespace weir
