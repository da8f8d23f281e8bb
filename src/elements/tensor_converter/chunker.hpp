// Chunker: time-stamps, and frames gathered into tensors of several frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/base/gstadapter.h>

#include <deque>

#include "core/limit/buffer_limit.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"

namespace weir {

bool known(const Fraction& rate) noexcept;  // and not 0
// The exact time of so many frames, rounded down once; `rate` must be known.
GstClockTime time_of(uint64_t frames, const Fraction& rate) noexcept;

class Chunker {
 public:
  Chunker() : adapter_(gst::Ref<GstAdapter>::adopt(gst_adapter_new())) {}

  // Sizes in bytes of one frame; frames per output.
  void configure(size_t frame_bytes, uint64_t frames_out, Fraction rate);
  uint64_t drop();   // the frames that wait; how many buffers are lost by it
  uint64_t clear();  // the same, and the time of the last one

  // Fills in what is missing (specification 2, "Timestamps"). `frames` in this buffer; `fallback`
  // is the time for a first buffer without one: the segment's start, or the running time of the
  // clock. The time of a buffer is counted in frames from the last time-stamp that was given, so
  // that no rounding adds up.
  void stamp(GstBuffer* buffer, uint64_t frames, GstClockTime fallback);

  // Takes the buffer. When it holds exactly one output's frames and none wait, next() gives it back
  // as it is. Otherwise its frames are cut or gathered. MAP_FAILED when they cannot be read and
  // LIMIT_EXCEEDED when an output gathered from several buffers is larger than `limit`; the buffer
  // is not taken then.
  Status push(gst::Ref<GstBuffer> buffer, const BufferLimit& limit);
  // Null when there are not enough frames. OUT_OF_MEMORY; the frames wait on then.
  Result<gst::Ref<GstBuffer>> next();
  // Buffers whose last byte left since this was asked last.
  uint64_t take_finished() noexcept { return std::exchange(finished_, 0); }
  // Bytes of several buffers that were gathered in one memory since this was asked last.
  uint64_t take_copied() noexcept { return std::exchange(copied_, 0); }

 private:
  struct Times {
    GstClockTime pts, dts;
  };
  Times times_of_next() const;  // of the first frame that waits
  void keep_time_of_next();     // in its buffer: the rate that counts to it goes
  void finish(size_t bytes);
  Result<gst::Ref<GstBuffer>> gather(size_t bytes);

  gst::Ref<GstAdapter> adapter_;
  gst::Ref<GstBuffer> whole_;
  size_t frame_bytes_ = 1;
  uint64_t frames_out_ = 1;
  Fraction rate_;
  GstClockTime anchor_ = GST_CLOCK_TIME_NONE;  // the last time that was given
  uint64_t frames_since_ = 0;                  // frames from the anchor to the next buffer
  GstClockTime duration_of_input_ = GST_CLOCK_TIME_NONE;
  uint64_t frames_of_input_ = 1;
  bool duration_is_counted_ = false;  // not given: of an output it is counted as well
  std::deque<size_t> waiting_;        // bytes that wait, of each buffer in the adapter
  uint64_t finished_ = 0, copied_ = 0;
};

}  // namespace weir
