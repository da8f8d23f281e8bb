// FrameSource: an appsrc, and the tensors that a program pushes into it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/app/app.h>

#include <mutex>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"

namespace weir::pipeline {

// CANCELLED: the pipeline is stopped.
Error not_started();

// Thread-safe.
class FrameSource {
 public:
  // Frame times are stream times: sets format=time. `is_replaceable`: no one else holds the appsrc.
  FrameSource(GstAppSrc* source, bool is_replaceable);

  // Whether the appsrc is a child of this bin, and not of one in it.
  bool is_in(const GstElement* bin) const { return GST_ELEMENT_PARENT(source().get()) == bin; }
  // See weir_pipeline_push.
  Status push(std::span<const weir_tensor> tensors, int64_t pts, int64_t duration);
  Status end();
  // See weir_pipeline_source_tensors.
  std::vector<TensorSpec> tensors();
  // The pipeline accepts frames from now on. Before this, and after stopped(), pushes are rejected,
  // including one in progress.
  void started();
  // The pipeline has stopped, and frames may have other caps after the next start. If the program
  // did not set the caps, a replaceable appsrc is replaced, because it cannot clear its caps.
  // Others start with the caps of the last frame.
  void stopped();

 private:
  void read_caps();  // which the program may have set
  void take_caps_of_next();
  void set_caps(GstCaps* caps);
  Result<gst::Ref<GstBuffer>> make_buffer(std::span<const weir_tensor> tensors);
  bool may_be_flexible() const;
  Status push_gap(std::span<const weir_tensor> tensors, int64_t pts, int64_t duration) const;
  Result<TensorSpec> find_spec(const weir_tensor& tensor, const TensorSpec* expected,
                               size_t index) const;
  Result<gst::Ref<GstBuffer>> tensor_buffer(std::span<const weir_tensor> tensors);
  Status write_caps(const std::vector<TensorSpec>& specs);
  Result<gst::Ref<GstBuffer>> media_buffer(std::span<const weir_tensor> tensors) const;
  Status to_status(GstFlowReturn flow) const;

  gst::Ref<GstAppSrc> source() const;

  const bool is_replaceable_;
  // Keeps caps and their frames together; taken before mutex_. Recursive: a push may call functions
  // of the program that push.
  std::recursive_mutex order_;
  mutable std::mutex mutex_;  // guards the rest; never held during a push
  gst::Ref<GstAppSrc> source_;
  gst::Ref<GstCaps> caps_;
  bool is_fixed_ = false;  // frames must fit caps_, which the program or the next element gave
  bool is_set_ = false;    // set_caps() set caps_
  bool asked_next_ = false, started_ = false;
  bool is_pushing_ = false;  // the thread that holds order_ pushes a frame of caps_
  FrameSpec spec_;           // of the caps; format End: not tensors
};

}  // namespace weir::pipeline
