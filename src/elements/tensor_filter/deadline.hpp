// Deadlines: the running time after which the result of a frame is useless.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace weir {

// The deadline of a frame with this running time; GST_CLOCK_TIME_NONE = none. `after`: nanoseconds,
// 0 = the user set no deadline.
inline GstClockTime deadline_of(GstClockTime running, GstClockTime after) noexcept {
  const bool ends =
      after > 0 && GST_CLOCK_TIME_IS_VALID(running) && running < GST_CLOCK_TIME_NONE - after;
  return ends ? running + after : GST_CLOCK_TIME_NONE;
}

// Whether the pipeline clock is past the deadline; false while there is no clock.
inline bool is_past(GstElement* element, GstClockTime deadline) noexcept {
  if (!GST_CLOCK_TIME_IS_VALID(deadline)) return false;
  const GstClockTime now = gst_element_get_current_running_time(element);
  return GST_CLOCK_TIME_IS_VALID(now) && now > deadline;
}

// The time of CLOCK_MONOTONIC, which is `monotonic` now, at which the running time, which is `now`,
// reaches `deadline`. At least 1, because 0 = none; INT64_MAX for what is beyond.
inline int64_t monotonic_at(GstClockTime deadline, GstClockTime now, int64_t monotonic) noexcept {
  const auto since_boot = static_cast<GstClockTime>(monotonic);
  if (deadline >= now)
    return static_cast<int64_t>(std::min(deadline - now, INT64_MAX - since_boot) + since_boot);
  const GstClockTime past = now - deadline;
  return past < since_boot ? static_cast<int64_t>(since_boot - past) : 1;
}

// The deadline by CLOCK_MONOTONIC, for engines that wait; 0 = none, or there is no clock.
inline int64_t monotonic_deadline(GstElement* element, GstClockTime deadline) noexcept {
  if (!GST_CLOCK_TIME_IS_VALID(deadline)) return 0;
  const GstClockTime now = gst_element_get_current_running_time(element);
  if (!GST_CLOCK_TIME_IS_VALID(now)) return 0;
  const std::chrono::nanoseconds monotonic = std::chrono::steady_clock::now().time_since_epoch();
  return monotonic_at(deadline, now, monotonic.count());
}

}  // namespace weir
