// LagWatch: posts a warning once when a live stream falls behind and when-busy is not set.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/infer/queue/falling_behind.hpp"

namespace weir {

class LagWatch {
 public:
  void set_element(GstElement* element, GstPad* sink) noexcept {
    element_ = element;
    sink_ = sink;
  }
  // Call before a new stream; `watching`: the warning may be posted.
  void open(bool watching) noexcept;
  // Streaming thread.
  void set_segment(GstEvent* segment) noexcept;
  // Streaming thread; call with each frame as it arrives. Reads the clock of a playing pipeline.
  // Posts FALLS_BEHIND at most once; only then it queries upstream whether the stream is live.
  void see(GstBuffer* buffer);

 private:
  bool is_live(GstClockTime* latency) const;

  GstElement* element_ = nullptr;  // the owner, borrowed
  GstPad* sink_ = nullptr;         // borrowed
  bool watching_ = false;
  GstSegment segment_{};
  infer::FallingBehind lag_;
};

}  // namespace weir
