// Deadlines: the running time after which the result of a frame is useless.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <algorithm>
#include <chrono>

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

// The deadline by CLOCK_MONOTONIC, for engines that wait; 0 = none, or there is no clock.
inline int64_t monotonic_deadline(GstElement* element, GstClockTime deadline) noexcept {
  if (!GST_CLOCK_TIME_IS_VALID(deadline)) return 0;
  const GstClockTime now = gst_element_get_current_running_time(element);
  if (!GST_CLOCK_TIME_IS_VALID(now)) return 0;
  const auto left = static_cast<int64_t>(deadline) - static_cast<int64_t>(now);
  const auto monotonic = std::chrono::steady_clock::now().time_since_epoch();
  return std::max<int64_t>(std::chrono::nanoseconds(monotonic).count() + left, 1);
}

}  // namespace weir
