// WindowStream: the frames of one stream (of one client), and the windows over them as buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/sync/backwards_time.hpp"
#include "core/window/window.hpp"
#include "elements/tensor_aggregator/window_strip.hpp"
#include "gstcpp/frame_pool.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir {

// What all clients share.
struct WindowSetup {
  FrameSpec input;
  window::Plan plan;
  size_t dimension = 15;
  uint64_t window_bytes = 0;
  gst::FramePool pool;  // of plan.memory
};

class WindowStream {
 public:
  explicit WindowStream(std::shared_ptr<WindowSetup> setup);

  // FRAME_SIZE and MAP_FAILED; the buffer is then not taken.
  Status push(gst::Ref<GstBuffer> buffer, Ledger* ledger);
  // The next window, null when frames are missing. Counts buffers whose last frame left.
  Result<gst::Ref<GstBuffer>> next(Ledger* ledger);

  // Gives what waits back, for a stream of other windows; of a buffer some of whose frames were
  // flushed none comes back.
  std::vector<gst::Ref<GstBuffer>> take_back(Ledger* ledger);
  // Forgets what waits. Buffers of which a window had a frame count as consumed, others as dropped.
  void clear(DropReason reason, Ledger* ledger);
  // Frames that came in no window, of buffers that are gone.
  uint64_t take_frames_lost() noexcept { return std::exchange(frames_lost_, 0); }

  BackwardsTimeWatch times;

 private:
  struct KnownTime {
    GstClockTime time = GST_CLOCK_TIME_NONE;
    uint64_t frame = 0;  // that has it
  };
  struct Arrived {
    ~Arrived() { reader.clear(); }
    gst::Ref<GstBuffer> buffer;
    gst::FrameReader reader;  // holds the buffer's memory mapped
    KnownTime pts, dts;       // the last ones up to this buffer
  };

  Arrived& holder_of(uint64_t frame);
  std::span<const std::byte> frame_of(size_t tensor, uint64_t frame);
  bool leaves_by_memory(uint64_t begin);
  // A part of the buffer that holds the window's frames; null where no single one does.
  Result<gst::Ref<GstMemory>> part_of_input(size_t tensor, uint64_t begin, uint64_t* copied);
  Result<gst::Ref<GstBuffer>> assembled(uint64_t begin, uint64_t* copied);
  Result<gst::Ref<GstBuffer>> gathered(uint64_t begin, uint64_t* copied);
  void place_all(size_t tensor, uint64_t begin, std::span<std::byte> out, uint64_t* copied);
  void describe(GstBuffer* out, uint64_t begin);
  void forget_before(uint64_t frame, DropReason reason, Ledger* ledger);
  uint64_t last_buffer_of(uint64_t begin) const noexcept;

  std::shared_ptr<WindowSetup> setup_;
  std::vector<WindowStrip> strips_;                 // by tensor; only where windows overlap
  std::vector<std::shared_ptr<BlockPool>> blocks_;  // by tensor; only of those interleaved
  std::deque<std::unique_ptr<Arrived>> waiting_;
  std::unique_ptr<Arrived> spare_;  // keeps its vectors for the next buffer
  uint64_t first_ = 0;              // number of the first buffer that waits
  uint64_t arrived_ = 0;            // frames
  uint64_t windows_ = 0;            // that left
  uint64_t used_ = 0;               // frames before this one were in a window, or are lost
  uint64_t frames_lost_ = 0;
  KnownTime pts_, dts_;
  GstClockTime duration_ = GST_CLOCK_TIME_NONE;  // of the buffer that came last
  gst::FramePool::Writer writer_;
};

}  // namespace weir
