// MemoryMapper: the memories of buffers as memories of messages of nnstreamer-edge.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "gstcpp/buffer/frame_layout.hpp"
#include "weir/result.hpp"

namespace weir {

struct MessageMemories {
  std::vector<std::span<const std::byte>> memories{};
  std::shared_ptr<const void> owner{};  // keeps the buffer, mapped
};

// One thread at a time.
class MemoryMapper {
 public:
  // The caps of the buffers that follow.
  void set_caps(const GstCaps* caps);
  // One memory for each tensor, or for each memory of a stream of other media. MAPPING_FAILED,
  // FRAME_SIZE, and the errors of gst::FrameLayout::locate().
  Result<MessageMemories> map(GstBuffer* buffer);

 private:
  bool has_tensors_ = false;
  FrameSpec spec_;
  gst::FrameLayout layout_;  // of streams of tensors
};

}  // namespace weir
