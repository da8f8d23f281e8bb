// Deadlines: the running time after which the result of a frame is useless.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

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

}  // namespace weir
