// Admission: decides which frames tensor_filter processes and which it drops before an invoke.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <optional>

#include "core/infer/model/invoke_statistics.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/throttling.hpp"

namespace weir {

class Admission {
 public:
  // `statistics` is borrowed.
  explicit Admission(const infer::InvokeStatistics* statistics) : statistics_(statistics) {}
  void set_pad(GstPad* sink) noexcept { sink_ = sink; }

  // Call before a new stream.
  void reset() noexcept;
  // Call after a flush. Keeps the throttling rate that downstream requested.
  void restart() noexcept;
  // Streaming thread.
  void set_segment(GstEvent* segment) noexcept { gst_event_copy_segment(segment, &segment_); }
  // What a QoS event reported.
  enum class QosResult { Lateness, Throttle };
  // Any thread: handles the lateness or the throttling that downstream reports.
  QosResult handle_qos(GstEvent* qos) noexcept;
  // Any thread: reads the properties, at the start and when they change.
  void configure(const FilterSettings& settings) noexcept;
  // Streaming thread: why the frame is dropped; nullopt = it is processed.
  std::optional<DropReason> drop_reason(GstBuffer* buffer) noexcept;
  // Streaming thread: the running time after which the frame is useless, or none.
  GstClockTime deadline_of(GstBuffer* buffer) const noexcept;

 private:
  GstClockTime running_time(GstBuffer* buffer) const noexcept;
  bool is_late(GstBuffer* buffer) const noexcept;

  const infer::InvokeStatistics* statistics_;
  GstPad* sink_ = nullptr;  // borrowed from the element
  std::atomic<bool> qos_{false};
  std::atomic<GstClockTime> deadline_{0};  // relative to the running time; 0 = none
  std::atomic<GstClockTime> earliest_{GST_CLOCK_TIME_NONE};  // running time
  Throttling throttling_;
  GstSegment segment_{};
};

}  // namespace weir
