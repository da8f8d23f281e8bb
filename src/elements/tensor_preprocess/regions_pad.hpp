// RegionsPad: the sink pad for box tensors of pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>

#include "core/preprocess/boxes.hpp"
#include "core/sync/timed_queue.hpp"
#include "gstcpp/buffer/result_boxes.hpp"
#include "gstcpp/pads/timed_tensors.hpp"

namespace weir {

// Takes plain boxes, or results: then those of all rows with a box that are not background. Queues
// boxes at their running time and forwards nothing. Errors of caps and buffers:
// check_boxes(), check_result_rows().
class RegionsPad final : public gst::TimedTensors {
 public:
  void end() override { queue_.end(); }
  // Call start() before a stream starts, and stop() to end the wait of its last frame.
  void start();
  void stop() { queue_.flush(true); }

  // Streaming thread of the pictures; `time` is a running time.
  sync::TimedOutcome take(GstClockTime time, GstClockTime max, preprocess::PictureRegions* out);
  void flush_pictures(bool on) { queue_.flush(on); }
  uint64_t unused() const { return queue_.unused(); }

 private:
  Status accept(const FrameSpec& spec) override;
  Status push(GstBuffer* buffer, const std::vector<gst::TensorPlace>& tensors,
              int64_t time) override;
  void advance(int64_t time) override { queue_.advance(time); }
  void flush(bool on) override;

  std::optional<gst::ResultBoxes> results_;  // none: plain boxes
  sync::TimedQueue<preprocess::PictureRegions> queue_;
};

}  // namespace weir
