// PulledFrame: a buffer from a pipeline, as tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"
#include "weir/source_map.hpp"

namespace weir::pipeline {

// The labels of the classes that the event weir-labels of a stream named, by weir-source.
using Labels = std::map<std::string, std::vector<std::string>, std::less<>>;

class PulledFrame {
 public:
  // A stream without tensor caps becomes one uint8 tensor. FORMAT_UNSUPPORTED for sparse tensors;
  // FrameLayout's errors for buffers that do not match their caps.
  // `labels` may be null.
  static Result<std::shared_ptr<const PulledFrame>> read(gst::Ref<GstBuffer> buffer,
                                                         gst::Ref<GstCaps> caps,
                                                         std::shared_ptr<const Labels> labels);
  ~PulledFrame();
  PulledFrame(const PulledFrame&) = delete;
  PulledFrame& operator=(const PulledFrame&) = delete;

  // Valid while the frame exists.
  const std::vector<weir_tensor>& tensors() const noexcept { return tensors_; }
  const std::string& caps() const noexcept { return caps_text_; }
  const char* caps_field(const char* field) const noexcept;  // "" if it is not a text
  // The label of a class of results tensor `index`; "" if the stream has none.
  const char* label(uint32_t index, int32_t class_index) const;
  std::span<const SourceMap> maps() const noexcept;
  int64_t pts() const noexcept;  // ns, -1 = none
  int64_t duration() const noexcept;

 private:
  PulledFrame(gst::Ref<GstBuffer> buffer, gst::Ref<GstCaps> caps,
              std::shared_ptr<const Labels> labels)
      : buffer_(std::move(buffer)), caps_(std::move(caps)), labels_(std::move(labels)) {}
  Status read_tensors(const FrameSpec& spec);
  Status read_bytes();
  void add(const TensorSpec& spec, std::span<std::byte> bytes);

  gst::Ref<GstBuffer> buffer_;
  gst::Ref<GstCaps> caps_;
  std::shared_ptr<const Labels> labels_;
  gst::FrameLayout reader_;
  // For a stream without tensor caps:
  gst::Ref<GstMemory> memory_;
  gst::MappedMemory bytes_;
  std::string caps_text_;
  std::vector<weir_tensor> tensors_;
};

}  // namespace weir::pipeline
