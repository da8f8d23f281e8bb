// Chunker: completes timestamps and collects frames into tensors of several frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/base/gstadapter.h>

#include <deque>

#include "core/limit/buffer_limit.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {

bool known(const Fraction& rate) noexcept;  // valid and not 0
// The exact duration of `frames`, rounded down once; `rate` must be known.
GstClockTime to_time(uint64_t frames, const Fraction& rate) noexcept;

class Chunker {
 public:
  Chunker() : adapter_(gst::Ref<GstAdapter>::adopt(gst_adapter_new())) {}

  // `frame_bytes`: the size of one frame in bytes. `frames_out`: frames per output.
  void configure(size_t frame_bytes, uint64_t frames_out, Fraction rate);
  uint64_t drop();   // drops waiting frames; returns how many buffers are lost
  uint64_t clear();  // the same, and forgets the last time

  // Fills in missing times (docs/compatibility/converter.md 2.6). The buffer holds `frames` frames;
  // `fallback` is the time of a first buffer without one: the segment's start or the clock's
  // running time. Later times are counted in frames from the last given timestamp, so that rounding
  // does not accumulate.
  void stamp(GstBuffer* buffer, uint64_t frames, GstClockTime fallback);

  // Accepts a buffer. If it holds exactly the frames of one output and none wait, next() returns it
  // unchanged; otherwise its frames are split or collected. The buffer is rejected with
  // MAPPING_FAILED when it cannot be read, or LIMIT_EXCEEDED when an output collected from several
  // buffers is larger than `limit`.
  Status push(gst::Ref<GstBuffer> buffer, const BufferLimit& limit);
  // Null when frames are missing. OUT_OF_MEMORY; the frames are kept then.
  Result<gst::Ref<GstBuffer>> next();
  // Buffers fully output since the last call.
  uint64_t take_finished() noexcept { return std::exchange(finished_, 0); }
  // Bytes copied since the last call to merge several buffers.
  uint64_t take_copied() noexcept { return std::exchange(copied_, 0); }

 private:
  struct Times {
    GstClockTime pts, dts;
  };
  Times times_of_next() const;  // of the first waiting frame
  void keep_time_of_next();     // stores it in its buffer before the rate changes
  void finish(size_t bytes);
  Result<gst::Ref<GstBuffer>> gather(size_t bytes);

  gst::Ref<GstAdapter> adapter_;
  gst::Ref<GstBuffer> whole_;
  size_t frame_bytes_ = 1;
  uint64_t frames_out_ = 1;
  Fraction rate_;
  GstClockTime anchor_ = GST_CLOCK_TIME_NONE;  // the last given timestamp
  uint64_t frames_since_ = 0;                  // frames from the anchor to the next buffer
  GstClockTime duration_of_input_ = GST_CLOCK_TIME_NONE;
  uint64_t frames_of_input_ = 1;
  bool duration_is_counted_ = false;  // not given; outputs count it too
  std::deque<size_t> waiting_;        // bytes left of each buffer in the adapter
  uint64_t finished_ = 0, copied_ = 0;
};

}  // namespace weir
