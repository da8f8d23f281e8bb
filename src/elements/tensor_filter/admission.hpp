// FrameAdmission: decides which frames tensor_filter processes and which it drops before an invoke,
// and warns when a live stream falls behind. Deadlines: the running time after which the result of
// a frame is useless.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "core/filter/throttle.hpp"
#include "core/infer/model/invoke_statistics.hpp"
#include "core/infer/queue/falling_behind.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// Whether the pipeline clock is past the deadline; false while there is no clock.
bool is_past(GstElement* element, GstClockTime deadline) noexcept;
// The time of CLOCK_MONOTONIC, which is `monotonic` now, at which the running time, which is `now`,
// reaches `deadline`. At least 1, because 0 = none; INT64_MAX for what is beyond.
int64_t monotonic_at(GstClockTime deadline, GstClockTime now, int64_t monotonic) noexcept;
// The deadline by CLOCK_MONOTONIC, for engines that wait; 0 = none, or there is no clock.
int64_t monotonic_deadline(GstElement* element, GstClockTime deadline) noexcept;

class FrameAdmission {
 public:
  // `statistics` is borrowed.
  explicit FrameAdmission(const infer::InvokeStatistics* statistics) : statistics_(statistics) {}
  void set_element(GstElement* element, GstPad* sink) noexcept {
    element_ = element;
    sink_ = sink;
  }

  // Call before a new stream.
  void reset(const FilterSettings& settings) noexcept;
  // Call after a flush. Keeps the throttling rate that downstream requested.
  void restart() noexcept;
  // Streaming thread.
  void set_segment(GstEvent* segment) noexcept;
  // What a QoS event reported.
  enum class QosResult { Lateness, Throttle };
  // Any thread: handles the lateness or the throttling that downstream reports. A THROTTLE event is
  // not forwarded.
  QosResult handle_qos(GstEvent* qos) noexcept;
  // Any thread: reads the properties, at the start and when they change.
  void configure(const FilterSettings& settings) noexcept;
  // Streaming thread; call with each frame as it arrives. Reads the clock of a playing pipeline.
  // Posts FALLS_BEHIND at most once, and only if when-busy is not set; only then it queries
  // upstream whether the stream is live.
  void warn_if_late(GstBuffer* buffer);
  // Streaming thread; call when it has processed or dropped a frame and waits for the next one.
  void note_idle() noexcept {
    if (may_warn_) idle_since_ = std::chrono::steady_clock::now();
  }
  // Streaming thread: why the frame is dropped; nullopt = it is processed. A frame that throttling
  // drops is reported upstream in a QoS event of type OVERFLOW.
  std::optional<DropReason> drop_reason(GstBuffer* buffer) noexcept;
  // Streaming thread: the running time after which the frame is useless, or none.
  GstClockTime get_deadline(GstBuffer* buffer) const noexcept;

 private:
  GstClockTime running_time(GstBuffer* buffer) const noexcept;
  bool is_late(GstBuffer* buffer) const noexcept;
  bool is_throttled(GstBuffer* buffer) noexcept;
  bool is_live(GstClockTime* latency) const;

  const infer::InvokeStatistics* statistics_;
  GstElement* element_ = nullptr;  // the owner, borrowed
  GstPad* sink_ = nullptr;         // borrowed
  std::atomic<bool> qos_{false};
  std::atomic<GstClockTime> deadline_{0};  // relative to the running time; 0 = none
  std::atomic<GstClockTime> earliest_{GST_CLOCK_TIME_NONE};  // running time
  Throttle throttle_;
  GstSegment segment_{};
  bool may_warn_ = false;  // FALLS_BEHIND was not posted, and may be
  infer::FallingBehind lag_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
};

}  // namespace weir
