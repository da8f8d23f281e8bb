// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/admission.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "gstcpp/element/error.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

using std::chrono::nanoseconds;

std::string in_seconds(GstClockTimeDiff lag) {
  return std::to_string(lag / GST_SECOND) + "." +
         std::to_string(lag % GST_SECOND / (100 * GST_MSECOND));
}

Error falls_behind(GstClockTimeDiff lag) {
  return Error{
      .code = Code::FALLS_BEHIND,
      .what = "the model is slower than the live source",
      .offered = "frames that are " + in_seconds(lag) + " s old when they arrive",
      .needed = "when-busy, which decides what happens to frames that cannot be processed in time",
      .fix = "tensor_filter when-busy=drop-old"};
}

}  // namespace

bool is_past(GstElement* element, GstClockTime deadline) noexcept {
  if (!GST_CLOCK_TIME_IS_VALID(deadline)) return false;
  const GstClockTime now = gst_element_get_current_running_time(element);
  return GST_CLOCK_TIME_IS_VALID(now) && now > deadline;
}

int64_t monotonic_at(GstClockTime deadline, GstClockTime now, int64_t monotonic) noexcept {
  const auto since_boot = static_cast<GstClockTime>(monotonic);
  if (deadline >= now)
    return static_cast<int64_t>(std::min(deadline - now, INT64_MAX - since_boot) + since_boot);
  const GstClockTime past = now - deadline;
  return past < since_boot ? static_cast<int64_t>(since_boot - past) : 1;
}

int64_t monotonic_deadline(GstElement* element, GstClockTime deadline) noexcept {
  if (!GST_CLOCK_TIME_IS_VALID(deadline)) return 0;
  const GstClockTime now = gst_element_get_current_running_time(element);
  if (!GST_CLOCK_TIME_IS_VALID(now)) return 0;
  const nanoseconds monotonic = std::chrono::steady_clock::now().time_since_epoch();
  return monotonic_at(deadline, now, monotonic.count());
}

void FrameAdmission::reset(const FilterSettings& settings) noexcept {
  restart();
  throttle_.reset();
  may_warn_ = settings.when_busy == WhenBusyChoice::Unset;
}

void FrameAdmission::restart() noexcept {
  earliest_ = GST_CLOCK_TIME_NONE;
  idle_since_.reset();
  throttle_.restart();
  gst_segment_init(&segment_, GST_FORMAT_UNDEFINED);
  lag_.reset();
}

void FrameAdmission::set_segment(GstEvent* segment) noexcept {
  gst_event_copy_segment(segment, &segment_);
  lag_.reset();
}

void FrameAdmission::configure(const FilterSettings& settings) noexcept {
  qos_ = settings.qos;
  deadline_ = settings.deadline;
}

FrameAdmission::QosResult FrameAdmission::handle_qos(GstEvent* qos) noexcept {
  GstQOSType type;
  gdouble proportion;
  GstClockTimeDiff diff;
  GstClockTime time;
  gst_event_parse_qos(qos, &type, &proportion, &diff, &time);
  if (type == GST_QOS_TYPE_THROTTLE && diff > 0) {
    throttle_.limit(static_cast<uint64_t>(diff));
    return QosResult::Throttle;
  }
  if (GST_CLOCK_TIME_IS_VALID(time) && (diff >= 0 || static_cast<GstClockTime>(-diff) <= time))
    earliest_ = time + static_cast<GstClockTime>(diff);
  return QosResult::Lateness;
}

GstClockTime FrameAdmission::running_time(GstBuffer* buffer) const noexcept {
  if (segment_.format != GST_FORMAT_TIME) return GST_CLOCK_TIME_NONE;
  return gst_segment_to_running_time(&segment_, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
}

void FrameAdmission::warn_if_late(GstBuffer* buffer) {
  const auto idle_since = std::exchange(idle_since_, std::nullopt);
  if (!may_warn_ || segment_.format != GST_FORMAT_TIME) return;
  const GstClockTime due = running_time(buffer);
  const auto clock = gst::Ref<GstClock>::adopt(gst_element_get_clock(element_));
  if (!clock || !GST_CLOCK_TIME_IS_VALID(due) || GST_STATE(element_) != GST_STATE_PLAYING) return;
  const GstClockTimeDiff now =
      GST_CLOCK_DIFF(gst_element_get_base_time(element_), gst_clock_get_time(clock.get()));
  const GstClockTimeDiff lag = now - static_cast<GstClockTimeDiff>(due);
  const auto idle = idle_since ? std::chrono::steady_clock::now() - *idle_since : nanoseconds(0);
  if (!lag_.observe(nanoseconds(now), nanoseconds(lag), idle)) return;
  GstClockTime latency = 0;
  may_warn_ = is_live(&latency);
  if (!may_warn_ || lag - static_cast<GstClockTimeDiff>(latency) <
                        nanoseconds(infer::FallingBehind::kLate).count())
    return;
  gst::post_warning(element_, falls_behind(lag));
  may_warn_ = false;
}

bool FrameAdmission::is_live(GstClockTime* latency) const {
  const gst::Unique<GstQuery, gst_query_unref> query(gst_query_new_latency());
  gboolean live = FALSE;
  if (!gst_pad_peer_query(sink_, query.get())) return false;
  gst_query_parse_latency(query.get(), &live, latency, nullptr);
  return live;
}

bool FrameAdmission::is_late(GstBuffer* buffer) const noexcept {
  const GstClockTime earliest = earliest_;
  if (!GST_CLOCK_TIME_IS_VALID(earliest) || !qos_) return false;
  const auto running = running_time(buffer);
  return GST_CLOCK_TIME_IS_VALID(running) && running <= earliest;
}

bool FrameAdmission::is_throttled(GstBuffer* buffer) noexcept {
  if (!GST_BUFFER_PTS_IS_VALID(buffer)) return false;
  const uint64_t latency = throttle_.limited() ? statistics_->latency_ns().value_or(0) : 0;
  std::optional<uint64_t> duration;
  if (GST_BUFFER_DURATION_IS_VALID(buffer)) duration = GST_BUFFER_DURATION(buffer);
  const auto overflow = throttle_.refuses(GST_BUFFER_PTS(buffer), duration, latency);
  if (!overflow) return false;
  const GstClockTime running = running_time(buffer);
  GstClockTimeDiff difference = overflow->difference;
  // GStreamer rejects QoS events with a timestamp below 0.
  if (GST_CLOCK_TIME_IS_VALID(running) && difference < 0)
    difference =
        -static_cast<GstClockTimeDiff>(std::min(static_cast<GstClockTime>(-difference), running));
  gst_pad_push_event(
      sink_, gst_event_new_qos(GST_QOS_TYPE_OVERFLOW, overflow->proportion, difference, running));
  return true;
}

std::optional<DropReason> FrameAdmission::drop_reason(GstBuffer* buffer) noexcept {
  // Throttling counts all frames, so it comes first.
  const bool drops = is_throttled(buffer) || is_late(buffer);
  return drops ? std::optional(DropReason::Qos) : std::nullopt;
}

GstClockTime FrameAdmission::get_deadline(GstBuffer* buffer) const noexcept {
  const GstClockTime after = deadline_, running = after ? running_time(buffer) : 0;
  const bool ends =
      after > 0 && GST_CLOCK_TIME_IS_VALID(running) && running < GST_CLOCK_TIME_NONE - after;
  return ends ? running + after : GST_CLOCK_TIME_NONE;
}

}  // namespace weir
