// QoS: a frame that would come too late, or that nobody wants, is not worth an invoke.
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

Admission::Heard Admission::hear(GstEvent* qos) noexcept {
  if (throttling_.hear(qos)) return Heard::Throttle;
  GstQOSType type;
  gdouble proportion;
  GstClockTimeDiff diff;
  GstClockTime time;
  gst_event_parse_qos(qos, &type, &proportion, &diff, &time);
  if (GST_CLOCK_TIME_IS_VALID(time) && (diff >= 0 || static_cast<GstClockTime>(-diff) <= time))
    earliest_ = time + static_cast<GstClockTime>(diff);
  return Heard::Lateness;
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

std::optional<DropReason> Admission::refuses(GstBuffer* buffer) noexcept {
  // It sees every frame: it adds up their distances.
  const uint64_t latency = throttling_.active() ? statistics_->latency_ns().value_or(0) : 0;
  if (throttling_.refuses(buffer, running_time(buffer), latency, sink_)) return DropReason::Qos;
  return is_late(buffer) ? std::optional(DropReason::Qos) : std::nullopt;
}

GstClockTime Admission::deadline_of(GstBuffer* buffer) const noexcept {
  const GstClockTime after = deadline_;
  return after ? weir::deadline_of(running_time(buffer), after) : GST_CLOCK_TIME_NONE;
}

}  // namespace weir
