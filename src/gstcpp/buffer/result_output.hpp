// ResultOutput: what an element that sends results adds to its frames: their place in the source
// picture, and frames without results in place of GAP events.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/limit/buffer_limit.hpp"
#include "core/tensor/result_roles.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Used on the streaming thread.
class ResultOutput {
 public:
  // The output caps; null or without weir-columns: the output is no results.
  void configure(const GstCaps* caps);
  bool is_results() const noexcept { return !roles_.empty(); }
  std::string source() const { return roles_.empty() ? std::string() : roles_[0].source; }
  // Replaces the source maps of the network's tensors, which `out` has: results are in pixels of
  // the picture, class maps and depths cover what the network saw.
  Status place(GstBuffer* out);
  // A frame without results and without a time; null if the columns are not valid. LIMIT_EXCEEDED.
  Result<Ref<GstBuffer>> empty_frame(const BufferLimit& limit) const;
  // The same with the time of a GAP event; null if the event has no time.
  Result<Ref<GstBuffer>> frame_of_gap(GstEvent* gap, const BufferLimit& limit) const;

 private:
  ResultRoles roles_;
  FrameLayout reader_;
};

}  // namespace weir::gst
