// LagWatch: tells the user once when a live stream falls behind and nothing says what is to be
// SPDX-License-Identifier: LGPL-2.1-or-later
// done.
#pragma once
#include <gst/gst.h>

#include "core/infer/falling_behind.hpp"

namespace weir {

class LagWatch {
 public:
  void set_element(GstElement* element, GstPad* sink) noexcept {
    element_ = element;
    sink_ = sink;
  }
  // A new stream of frames may come; `watching`: something is to be told.
  void open(bool watching) noexcept;
  // Streaming thread.
  void set_segment(GstEvent* segment) noexcept;
  // Streaming thread, each frame as it comes: reads the clock of a pipeline that plays. Posts
  // FALLS_BEHIND at most once, and asks upstream whether it is live only then.
  void see(GstBuffer* buffer);

 private:
  bool is_live(GstClockTime* latency) const;

  GstElement* element_ = nullptr;  // borrowed: the owner
  GstPad* sink_ = nullptr;         // borrowed
  bool watching_ = false;
  GstSegment segment_{};
  infer::FallingBehind behind_;
};

}  // namespace weir
