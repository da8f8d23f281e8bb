// Compares the running time of frames with the clock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/lag_watch.hpp"

#include <string>

#include "gstcpp/element/error.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

using std::chrono::nanoseconds;

std::string seconds(GstClockTimeDiff lag) {
  return std::to_string(lag / GST_SECOND) + "." +
         std::to_string(lag % GST_SECOND / (100 * GST_MSECOND));
}

Error is_late(GstClockTimeDiff lag) {
  return Error{
      .code = Code::FALLS_BEHIND,
      .what = "the model is slower than the live source",
      .offered = "frames that are " + seconds(lag) + " s old when they arrive",
      .needed = "when-busy, which decides what happens to frames that cannot be processed in time",
      .fix = "tensor_filter when-busy=drop-old"};
}

}  // namespace

void LagWatch::open(bool watching) noexcept {
  watching_ = watching;
  gst_segment_init(&segment_, GST_FORMAT_UNDEFINED);
  lag_.reset();
}

void LagWatch::set_segment(GstEvent* segment) noexcept {
  gst_event_copy_segment(segment, &segment_);
  lag_.reset();
}

void LagWatch::see(GstBuffer* buffer) {
  if (!watching_ || segment_.format != GST_FORMAT_TIME) return;
  const GstClockTime due =
      gst_segment_to_running_time(&segment_, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  const auto clock = gst::Ref<GstClock>::adopt(gst_element_get_clock(element_));
  if (!clock || !GST_CLOCK_TIME_IS_VALID(due) || GST_STATE(element_) != GST_STATE_PLAYING) return;
  const GstClockTimeDiff now =
      GST_CLOCK_DIFF(gst_element_get_base_time(element_), gst_clock_get_time(clock.get()));
  const GstClockTimeDiff lag = now - static_cast<GstClockTimeDiff>(due);
  if (!lag_.observe(nanoseconds(now), nanoseconds(lag))) return;
  GstClockTime latency = 0;
  watching_ = is_live(&latency);
  if (!watching_ || lag - static_cast<GstClockTimeDiff>(latency) <
                        nanoseconds(infer::FallingBehind::kLate).count())
    return;
  gst::post_warning(element_, is_late(lag));
  watching_ = false;
}

bool LagWatch::is_live(GstClockTime* latency) const {
  const gst::Unique<GstQuery, gst_query_unref> query(gst_query_new_latency());
  gboolean live = FALSE;
  if (!gst_pad_peer_query(sink_, query.get())) return false;
  gst_query_parse_latency(query.get(), &live, latency, nullptr);
  return live;
}

}  // namespace weir
