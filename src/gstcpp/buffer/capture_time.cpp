// Finds the time of capture in reference timestamps and clocks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/capture_time.hpp"

#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

// NTP counts from 1900.
constexpr GstClockTime kNtpAtUnixEpoch = GstClockTime{2208988800} * GST_SECOND;

GstClockTime reference_time(GstBuffer* buffer, const char* media_type) {
  gpointer state = nullptr;
  while (GstMeta* meta = gst_buffer_iterate_meta_filtered(buffer, &state,
                                                          GST_REFERENCE_TIMESTAMP_META_API_TYPE)) {
    const auto* found = reinterpret_cast<GstReferenceTimestampMeta*>(meta);
    const GstStructure* reference = gst_caps_get_structure(found->reference, 0);
    if (gst_structure_has_name(reference, media_type)) return found->timestamp;
  }
  return GST_CLOCK_TIME_NONE;
}

// The clock's time of the buffer's running time.
GstClockTime realtime_of(GstBuffer* buffer, const GstSegment& segment, GstElement* element) {
  const auto clock = Ref<GstClock>::adopt(gst_element_get_clock(element));
  if (!clock || !GST_IS_SYSTEM_CLOCK(clock.get())) return GST_CLOCK_TIME_NONE;
  GstClockType type = GST_CLOCK_TYPE_MONOTONIC;
  g_object_get(clock.get(), "clock-type", &type, nullptr);
  if (type != GST_CLOCK_TYPE_REALTIME || segment.format != GST_FORMAT_TIME)
    return GST_CLOCK_TIME_NONE;
  const GstClockTime running =
      gst_segment_to_running_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  const GstClockTime base = gst_element_get_base_time(element);
  if (!GST_CLOCK_TIME_IS_VALID(running) || !GST_CLOCK_TIME_IS_VALID(base))
    return GST_CLOCK_TIME_NONE;
  return base + running;
}

}  // namespace

int64_t unix_time_of(GstBuffer* buffer, const GstSegment& segment, GstElement* element) {
  GstClockTime time = reference_time(buffer, "timestamp/x-unix");
  if (!GST_CLOCK_TIME_IS_VALID(time)) {
    time = reference_time(buffer, "timestamp/x-ntp");
    if (GST_CLOCK_TIME_IS_VALID(time))
      time = time >= kNtpAtUnixEpoch ? time - kNtpAtUnixEpoch : GST_CLOCK_TIME_NONE;
  }
  if (!GST_CLOCK_TIME_IS_VALID(time)) time = realtime_of(buffer, segment, element);
  return time <= static_cast<GstClockTime>(INT64_MAX) ? static_cast<int64_t>(time) : -1;
}

}  // namespace weir::gst
