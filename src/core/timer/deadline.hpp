// deadline_after: a point in time that stays in range however long the delay is.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>

namespace weir {

// `from` + `delay`, and the last point that the clock can name where the sum is beyond it.
template <class Clock, class Duration>
std::chrono::time_point<Clock, Duration> deadline_after(
    std::chrono::time_point<Clock, Duration> from, std::chrono::nanoseconds delay) {
  using Time = std::chrono::time_point<Clock, Duration>;
  return from.time_since_epoch().count() > 0 && delay > Time::max() - from ? Time::max()
                                                                           : from + delay;
}

}  // namespace weir
