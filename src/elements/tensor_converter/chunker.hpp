// Chunker: time-stamps, and frames gathered into tensors of several frames.
#pragma once
#include <gst/base/gstadapter.h>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"

namespace weir {

class Chunker {
 public:
  Chunker() : adapter_(gst::Ref<GstAdapter>::adopt(gst_adapter_new())) {}

  // Sizes in bytes of one frame; frames per output.
  void configure(size_t frame_bytes, uint64_t frames_out, Fraction rate);
  void clear();  // frames and the time of the last one

  // Fills in what is missing (specification 2, "Timestamps"). `frames` in this buffer; `fallback`
  // is the time for a first buffer without one: the segment's start, or the running time of the
  // clock.
  void stamp(GstBuffer* buffer, uint64_t frames, GstClockTime fallback);

  // Takes the buffer. When it holds exactly one output's frames and none wait, next() gives it back
  // as it is.
  void push(gst::Ref<GstBuffer> buffer);
  gst::Ref<GstBuffer> next();  // null when there are not enough frames
  uint64_t frames_waiting() const { return gst_adapter_available(adapter_.get()) / frame_bytes_; }

 private:
  gst::Ref<GstAdapter> adapter_;
  gst::Ref<GstBuffer> whole_;
  size_t frame_bytes_ = 1;
  uint64_t frames_out_ = 1;
  Fraction rate_;
  GstClockTime next_pts_ = GST_CLOCK_TIME_NONE;
  GstClockTime duration_of_input_ = GST_CLOCK_TIME_NONE;
  uint64_t frames_of_input_ = 1;
};

}  // namespace weir
