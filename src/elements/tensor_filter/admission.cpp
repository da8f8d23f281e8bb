// Drops frames whose result would come too late or is not needed downstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/admission.hpp"

#include "elements/tensor_filter/deadline.hpp"

namespace weir {

void Admission::reset() noexcept {
  restart();
  throttling_.reset();
}

void Admission::restart() noexcept {
  earliest_ = GST_CLOCK_TIME_NONE;
  throttling_.restart();
  gst_segment_init(&segment_, GST_FORMAT_UNDEFINED);
}

void Admission::configure(const FilterSettings& settings) noexcept {
  qos_ = settings.qos;
  deadline_ = settings.deadline;
}

Admission::QosResult Admission::handle_qos(GstEvent* qos) noexcept {
  if (throttling_.handle_qos(qos)) return QosResult::Throttle;
  GstQOSType type;
  gdouble proportion;
  GstClockTimeDiff diff;
  GstClockTime time;
  gst_event_parse_qos(qos, &type, &proportion, &diff, &time);
  if (GST_CLOCK_TIME_IS_VALID(time) && (diff >= 0 || static_cast<GstClockTime>(-diff) <= time))
    earliest_ = time + static_cast<GstClockTime>(diff);
  return QosResult::Lateness;
}

GstClockTime Admission::running_time(GstBuffer* buffer) const noexcept {
  if (segment_.format != GST_FORMAT_TIME) return GST_CLOCK_TIME_NONE;
  return gst_segment_to_running_time(&segment_, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
}

bool Admission::is_late(GstBuffer* buffer) const noexcept {
  const GstClockTime earliest = earliest_;
  if (!GST_CLOCK_TIME_IS_VALID(earliest) || !qos_) return false;
  const auto running = running_time(buffer);
  return GST_CLOCK_TIME_IS_VALID(running) && running <= earliest;
}

std::optional<DropReason> Admission::drop_reason(GstBuffer* buffer) noexcept {
  // Throttling counts all frames, so it comes first.
  const uint64_t latency = throttling_.active() ? statistics_->latency_ns().value_or(0) : 0;
  if (throttling_.should_drop(buffer, running_time(buffer), latency, sink_)) return DropReason::Qos;
  return is_late(buffer) ? std::optional(DropReason::Qos) : std::nullopt;
}

GstClockTime Admission::deadline_of(GstBuffer* buffer) const noexcept {
  const GstClockTime after = deadline_;
  return after ? weir::deadline_of(running_time(buffer), after) : GST_CLOCK_TIME_NONE;
}

}  // namespace weir
