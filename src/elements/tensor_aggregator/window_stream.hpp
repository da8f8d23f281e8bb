// WindowStream: the frames of one client's stream, and windows over them as buffers.
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
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/frame_pool.hpp"

namespace weir {

// Shared by all clients.
struct WindowSetup {
  FrameSpec input;
  window::WindowPlan plan;
  size_t dimension = 15;
  uint64_t window_bytes = 0;
  gst::FramePool pool;  // of plan.memory
};

class WindowStream {
 public:
  explicit WindowStream(std::shared_ptr<WindowSetup> setup);

  // FRAME_SIZE and MAPPING_FAILED; the buffer is rejected then.
  Status push(gst::Ref<GstBuffer> buffer, Ledger* ledger);
  // Returns the next window, or null when frames are missing. Counts buffers that are used up.
  Result<gst::Ref<GstBuffer>> next(Ledger* ledger);

  // Returns the waiting buffers for a stream of other windows, except buffers some of whose frames
  // were flushed.
  std::vector<gst::Ref<GstBuffer>> take_back(Ledger* ledger);
  // Drops the waiting buffers: those with a frame in a window count as consumed, others as dropped.
  void clear(DropReason reason, Ledger* ledger);
  // Frames of released buffers that were in no window.
  uint64_t take_frames_lost() noexcept { return std::exchange(frames_lost_, 0); }

  BackwardsTimeWatch times;

 private:
  struct KnownTime {
    GstClockTime time = GST_CLOCK_TIME_NONE;
    uint64_t frame = 0;  // the frame with this time
  };
  struct Arrived {
    ~Arrived() { reader.clear(); }
    gst::Ref<GstBuffer> buffer;
    gst::FrameLayout reader;  // holds the buffer's memory mapped
    KnownTime pts, dts;       // the last known times up to this buffer
  };

  Arrived& find_holder(uint64_t frame);
  std::span<const std::byte> get_frame(size_t tensor, uint64_t frame);
  bool leaves_by_memory(uint64_t begin);
  // A part of the buffer that holds all frames of the window; null if they span buffers.
  Result<gst::Ref<GstMemory>> part_of_input(size_t tensor, uint64_t begin, uint64_t* copied);
  Result<gst::Ref<GstBuffer>> assembled(uint64_t begin, uint64_t* copied);
  Result<gst::Ref<GstBuffer>> gathered(uint64_t begin, uint64_t* copied);
  void place_all(size_t tensor, uint64_t begin, std::span<std::byte> out, uint64_t* copied);
  void describe(GstBuffer* out, uint64_t begin);
  void forget_before(uint64_t frame, DropReason reason, Ledger* ledger);
  uint64_t find_last_buffer(uint64_t begin) const noexcept;

  std::shared_ptr<WindowSetup> setup_;
  std::vector<WindowStrip> strips_;                 // by tensor; only if windows overlap
  std::vector<std::shared_ptr<StripPool>> blocks_;  // by tensor; only for interleaved ones
  std::deque<std::unique_ptr<Arrived>> waiting_;
  std::unique_ptr<Arrived> spare_;  // keeps its vectors for the next buffer
  uint64_t first_ = 0;              // index of the oldest waiting buffer
  uint64_t arrived_ = 0;            // frames received
  uint64_t windows_ = 0;            // windows output
  uint64_t used_ = 0;               // frames before this index were in a window or are lost
  uint64_t frames_lost_ = 0;
  KnownTime pts_, dts_;
  GstClockTime duration_ = GST_CLOCK_TIME_NONE;  // of the last buffer
  gst::FramePool::Writer writer_;
};

}  // namespace weir
