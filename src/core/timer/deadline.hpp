// deadline_after: a point in time that stays in the clock's range for any delay.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>

namespace weir {

// `from` + `delay`, clamped to the clock's last point in time.
template <class Clock, class Duration>
std::chrono::time_point<Clock, Duration> deadline_after(
    std::chrono::time_point<Clock, Duration> from, std::chrono::nanoseconds delay) {
  using Time = std::chrono::time_point<Clock, Duration>;
  return from.time_since_epoch().count() > 0 && delay > Time::max() - from ? Time::max()
                                                                           : from + delay;
}

}  // namespace weir
