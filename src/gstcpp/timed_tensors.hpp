// TimedTensors: a sink pad whose tensors go no further, but to the pictures of another pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir::gst {

// None without a time, beyond the segment, and in segments that are not of time.
GstClockTime running_time(const GstSegment& segment, GstClockTime time);

// Reads what comes on the pad; who derives from it says what is taken and keeps it. Threads of the
// pad.
class TimedTensors {
 public:
  virtual ~TimedTensors() = default;
  // Errors: spec_from_caps(), accept().
  Status handle(GstEvent* event);
  // Errors: NOT_NEGOTIATED before caps, FrameReader::read(), bring().
  Status receive(GstBuffer* buffer);
  // While the pad is inactive: its caps and segment are not those of the next stream.
  void forget_stream();

 protected:
  TimedTensors();
  // New caps; the frames that follow hold this.
  virtual Status accept(const FrameSpec& spec) = 0;
  // `tensors` are mapped for the length of the call. `time` is a running time; INT64_MIN: none.
  virtual Status bring(GstBuffer* buffer, const std::vector<TensorView>& tensors, int64_t time) = 0;
  virtual void advance(int64_t time) = 0;  // nothing of an earlier running time will come
  virtual void end() = 0;                  // nothing will come, until flushed
  virtual void flush(bool on) = 0;         // off: a new stream begins

 private:
  void gap(GstEvent* event);

  FrameSpec spec_;
  GstSegment segment_;
  FrameReader reader_;
};

}  // namespace weir::gst
