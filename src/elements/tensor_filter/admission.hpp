// Admission: which frames tensor_filter takes, and which are dropped before they cost an invoke.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <optional>

#include "core/infer/invoke_statistics.hpp"
#include "core/ledger/ledger.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/throttling.hpp"

namespace weir {

class Admission {
 public:
  // Borrowed.
  explicit Admission(const infer::InvokeStatistics* statistics) : statistics_(statistics) {}
  void set_pad(GstPad* sink) noexcept { sink_ = sink; }

  // A new stream.
  void reset() noexcept;
  // After a flush. What the elements behind want at most stays.
  void restart() noexcept;
  // Streaming thread.
  void set_segment(GstEvent* segment) noexcept { gst_event_copy_segment(segment, &segment_); }
  // What is heard of an event of QoS.
  enum class Heard { Lateness, Throttle };
  // Any thread: what the elements behind say of their lateness, or of the frames they do not want.
  Heard hear(GstEvent* qos) noexcept;
  // Any thread: what the user wants, at the start and when it changes.
  void configure(const FilterSettings& settings) noexcept;
  // Streaming thread: why the frame is not taken; nullopt = it is.
  std::optional<DropReason> refuses(GstBuffer* buffer) noexcept;
  // Streaming thread: the running time from which on the frame is worthless, or none.
  GstClockTime deadline_of(GstBuffer* buffer) const noexcept;

 private:
  GstClockTime running_time(GstBuffer* buffer) const noexcept;
  bool is_late(GstBuffer* buffer) const noexcept;

  const infer::InvokeStatistics* statistics_;
  GstPad* sink_ = nullptr;  // borrowed from the element
  std::atomic<bool> qos_{false};
  std::atomic<GstClockTime> deadline_{0};                    // after the running time; 0 = none
  std::atomic<GstClockTime> earliest_{GST_CLOCK_TIME_NONE};  // running time
  Throttling throttling_;
  GstSegment segment_{};
};

}  // namespace weir
