// Deadlines: the running time from which on a frame's result is worth nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir {

// When a frame of this running time is worthless; GST_CLOCK_TIME_NONE = never. `after`: ns, 0 = the
// user set no deadline.
inline GstClockTime deadline_of(GstClockTime running, GstClockTime after) noexcept {
  const bool ends =
      after > 0 && GST_CLOCK_TIME_IS_VALID(running) && running < GST_CLOCK_TIME_NONE - after;
  return ends ? running + after : GST_CLOCK_TIME_NONE;
}

// Whether it is too late to begin by the clock of the pipeline; never while there is no clock.
inline bool is_past(GstElement* element, GstClockTime deadline) noexcept {
  if (!GST_CLOCK_TIME_IS_VALID(deadline)) return false;
  const GstClockTime now = gst_element_get_current_running_time(element);
  return GST_CLOCK_TIME_IS_VALID(now) && now > deadline;
}

}  // namespace weir
