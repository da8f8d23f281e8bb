// RestartBackoff: the delay before a worker process that ended is replaced.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <chrono>

namespace weir::isolate {

// No delay after the first end, then 100 ms, 200 ms, 400 ms and so on up to 10 s. A worker that ran
// for 10 s resets the sequence.
class RestartBackoff {
 public:
  using Clock = std::chrono::steady_clock;

  void started(Clock::time_point now) noexcept { started_ = now; }
  // The delay after an end at `now`.
  Clock::duration ended(Clock::time_point now) noexcept {
    if (now - started_ >= kQuiet) next_ = {};
    const auto wait = next_;
    next_ = wait == Clock::duration{} ? Clock::duration(kFirst)
                                      : std::min(2 * wait, Clock::duration(kMax));
    return wait;
  }

 private:
  static constexpr std::chrono::milliseconds kFirst{100};
  static constexpr std::chrono::seconds kMax{10}, kQuiet{10};
  Clock::time_point started_{};
  Clock::duration next_{};
};

}  // namespace weir::isolate
