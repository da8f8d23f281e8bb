// RegionsPad: the sink pad on which the boxes of pictures come as tensors.
#pragma once
#include <gst/gst.h>

#include "core/preprocess/box_queue.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir {

// None without a time, beyond the segment, and in segments that are not of time.
GstClockTime running_time(const GstSegment& segment, GstClockTime time);

// What comes on the pad goes no further: boxes into the queue, at their running time.
class RegionsPad {
 public:
  // Threads of the pad. Errors of caps and buffers: check_boxes(), FrameReader::read().
  Status handle(GstEvent* event);
  Status receive(GstBuffer* buffer);
  void end() { queue_.end(); }
  // Before a stream begins, and when its last frame shall wait no more.
  void start();
  void stop() { queue_.flush(true); }

  // Streaming thread of the pictures; `time` is a running time.
  preprocess::BoxQueue::Outcome take(GstClockTime time, GstClockTime most,
                                     std::vector<preprocess::Box>* out);
  void flush_pictures(bool on) { queue_.flush(on); }
  uint64_t unused() const { return queue_.unused(); }

 private:
  Status set_caps(const GstCaps* caps);
  void gap(GstClockTime begin, GstClockTime duration);
  Status read_boxes(std::vector<preprocess::Box>* boxes) const;

  FrameSpec spec_;
  GstSegment segment_ = initial_segment();
  gst::FrameReader reader_;
  preprocess::BoxQueue queue_;

  static GstSegment initial_segment() noexcept;
};

}  // namespace weir
