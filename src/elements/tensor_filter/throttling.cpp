// Handles THROTTLE events and sends OVERFLOW events.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/throttling.hpp"

#include <algorithm>

namespace weir {

bool Throttling::handle_qos(GstEvent* qos) noexcept {
  GstQOSType type = GST_QOS_TYPE_UNDERFLOW;
  GstClockTimeDiff delay = 0;
  gst_event_parse_qos(qos, &type, nullptr, &delay, nullptr);
  if (type != GST_QOS_TYPE_THROTTLE || delay <= 0) return false;
  throttle_.limit(static_cast<uint64_t>(delay));
  return true;
}

bool Throttling::should_drop(GstBuffer* buffer, GstClockTime running, uint64_t latency,
                             GstPad* sink) noexcept {
  if (!GST_BUFFER_PTS_IS_VALID(buffer)) return false;
  std::optional<uint64_t> duration;
  if (GST_BUFFER_DURATION_IS_VALID(buffer)) duration = GST_BUFFER_DURATION(buffer);
  const auto overflow = throttle_.refuses(GST_BUFFER_PTS(buffer), duration, latency);
  if (!overflow) return false;
  GstClockTimeDiff difference = overflow->difference;
  // GStreamer rejects QoS events with a timestamp below 0.
  if (GST_CLOCK_TIME_IS_VALID(running) && difference < 0)
    difference =
        -static_cast<GstClockTimeDiff>(std::min(static_cast<GstClockTime>(-difference), running));
  gst_pad_push_event(
      sink, gst_event_new_qos(GST_QOS_TYPE_OVERFLOW, overflow->proportion, difference, running));
  return true;
}

}  // namespace weir
