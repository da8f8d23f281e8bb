// The memories of a message in NNStreamer's protocol: one for each tensor, or for each memory of
// other media.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "gstcpp/buffer/frame_parts.hpp"
#include "weir/result.hpp"

namespace weir {

struct MessageMemories {
  std::vector<std::span<const std::byte>> memories;
  std::shared_ptr<const void> owner;  // keeps them
};

// Used by one thread.
class MessageSplitter {
 public:
  // The caps of the buffers that follow.
  void set_caps(GstCaps* caps);
  // MAPPING_FAILED; FRAME_SIZE for a tensor that lies in several memories, and as of
  // FrameParts::read().
  Result<MessageMemories> split(GstBuffer* buffer);

 private:
  bool has_tensors_ = false;
  gst::FrameParts parts_;
};

}  // namespace weir
