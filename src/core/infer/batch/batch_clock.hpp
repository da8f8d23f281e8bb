// BatchClock: the clock of a collector, including its waits; tests replace it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <mutex>

namespace weir::infer {

class BatchClock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  virtual ~BatchClock() = default;
  virtual Time now() = 0;
  // Waits for `changed` (locked with `lock`) until `until`; may return early.
  virtual void wait_until(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                          Time until) = 0;
  // The steady clock.
  static BatchClock& machine();
};

}  // namespace weir::infer
