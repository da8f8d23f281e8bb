// TimedTensors: a sink pad whose tensors are used with the pictures of another pad, not forwarded.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "core/records/source_labels.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::gst {

// None for a buffer without a time or outside the segment, and in segments not in TIME format.
GstClockTime running_time(const GstSegment& segment, GstClockTime time);

// Reads the data of the pad; a subclass decides what is accepted and stores it. Threads of the pad.
class TimedTensors {
 public:
  virtual ~TimedTensors() = default;
  // Errors: spec_from_caps(), accept().
  Status handle(GstEvent* event);
  // Errors: NOT_NEGOTIATED before caps, FrameLayout::read(), push().
  Status receive(GstBuffer* buffer);
  // Call while the pad is inactive: clears its caps and segment for the next stream.
  void forget_stream();

 protected:
  TimedTensors();
  // New caps; they apply to the frames that follow.
  virtual Status accept(const FrameSpec& spec) = 0;
  // `tensors` are mapped during the call. `time` is a running time; INT64_MIN: none.
  virtual Status push(GstBuffer* buffer, const std::vector<TensorPlace>& tensors, int64_t time) = 0;
  virtual void advance(int64_t time) = 0;  // no data before this running time follows
  virtual void end() = 0;                  // no data follows until a flush
  virtual void flush(bool on) = 0;         // off: a new stream starts
  // The names of classes that the stream has by now; called for new caps and for new names.
  virtual void set_labels(const records::LabelsBySource&) {}
  // The zones of the stream.
  virtual void set_zones(const ZonesOfSource&) {}

 private:
  void gap(GstEvent* event);

  FrameSpec spec_;
  records::LabelsBySource labels_;
  GstSegment segment_;
  FrameLayout reader_;
};

}  // namespace weir::gst
