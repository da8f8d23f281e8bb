// MessageBuffers: buffers of the memories of messages in NNStreamer's protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// One thread at a time.
class MessageBuffers {
 public:
  // The caps of the buffers that follow.
  void set_caps(const GstCaps* caps);
  // A buffer of these memories, without copying them, but for the tensors from the 16th on, whose
  // bytes are added to `copied`. PEER_MESSAGE_INVALID if number and sizes are not those of static
  // caps, and for more than 16 memories that are not tensors; a frame that has fewer memories than
  // tensors is not checked.
  Result<gst::Ref<GstBuffer>> make(std::vector<gst::Ref<GstMemory>> memories,
                                   uint64_t* copied) const;
  // The same; the buffer owns the blocks.
  Result<gst::Ref<GstBuffer>> make(std::vector<wire::ByteBlock> blocks, uint64_t* copied) const;

 private:
  Status pack(std::vector<gst::Ref<GstMemory>> memories, GstBuffer* out, uint64_t* copied) const;

  std::vector<TensorSpec> tensors_;  // of static caps
  bool has_headers_ = false;         // each tensor, of flexible and sparse caps
};

}  // namespace weir
