// FrameSource: an appsrc, and the tensors that a program hands to it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/app/app.h>

#include <mutex>
#include <span>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"
#include "weir/abi.h"

namespace weir::pipeline {

// CANCELLED: the pipeline is stopped.
Error not_started();

// Thread-safe.
class FrameSource {
 public:
  // Times of the frames are those of the stream: sets format=time.
  explicit FrameSource(GstAppSrc* source);

  // As weir_pipeline_push says.
  Status push(std::span<const weir_tensor> tensors, int64_t pts, int64_t duration);
  Status end();
  // The pipeline takes frames from now on: until then and behind stopped() a push is refused, also
  // one that was on its way.
  void started();
  // The pipeline has stopped, and frames may have other caps when it starts again: where frames
  // wrote the caps, another appsrc takes the place of the old one, which cannot be told to forget
  // them.
  void stopped();

 private:
  Status agree(std::span<const weir_tensor> tensors, std::vector<TensorSpec>* specs);
  Status write_caps(const std::vector<TensorSpec>& specs);
  Status check_media(std::span<const weir_tensor> tensors) const;
  Status answer(GstFlowReturn flow) const;

  gst::Ref<GstAppSrc> source() const;

  mutable std::mutex mutex_;  // guards the rest: caps and their frames stay together
  gst::Ref<GstAppSrc> source_;
  gst::Ref<GstCaps> caps_;
  bool caps_given_ = false, started_ = false;
  FrameSpec spec_;  // of the caps; format End: no tensors
};

}  // namespace weir::pipeline
