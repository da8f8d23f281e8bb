// PulledFrame: a buffer from a pipeline, as tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <string>
#include <vector>

#include "gstcpp/buffer/frame_reader.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"

namespace weir::pipeline {

class PulledFrame {
 public:
  // A stream without tensor caps becomes one uint8 tensor. FORMAT_UNSUPPORTED for sparse tensors;
  // FrameReader's errors for buffers that do not match their caps.
  static Result<std::shared_ptr<const PulledFrame>> read(gst::Ref<GstBuffer> buffer,
                                                         const gst::Ref<GstCaps>& caps);
  ~PulledFrame();
  PulledFrame(const PulledFrame&) = delete;
  PulledFrame& operator=(const PulledFrame&) = delete;

  // Valid while the frame exists.
  const std::vector<weir_tensor>& tensors() const noexcept { return tensors_; }
  const std::string& caps() const noexcept { return caps_; }
  int64_t pts() const noexcept;  // ns, -1 = none
  int64_t duration() const noexcept;

 private:
  explicit PulledFrame(gst::Ref<GstBuffer> buffer) : buffer_(std::move(buffer)) {}
  Status read_tensors(const FrameSpec& spec);
  Status read_bytes();
  void add(const TensorSpec& spec, std::span<std::byte> bytes);

  gst::Ref<GstBuffer> buffer_;
  gst::FrameReader reader_;
  // For a stream without tensor caps:
  gst::Ref<GstMemory> memory_;
  gst::MappedMemory bytes_;
  std::string caps_;
  std::vector<weir_tensor> tensors_;
};

}  // namespace weir::pipeline
