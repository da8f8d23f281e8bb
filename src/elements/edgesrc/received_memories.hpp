// Buffers of the memories of a message in NNStreamer's protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "elements/edgesrc/buffer_input.hpp"

namespace weir {

// Used by one thread.
class BufferAssembler {
 public:
  // The caps of the messages that follow.
  void set_caps(const GstCaps* caps);
  // A buffer of one memory for each of the message; more than 16 tensors are packed as in buffers,
  // which is counted as copied. PEER_MESSAGE_INVALID for a frame unlike static caps, and for one of
  // more than 16 memories that are not tensors.
  Result<InputEvent> assemble(std::vector<gst::Ref<GstMemory>> memories) const;

 private:
  std::vector<TensorSpec> tensors_;  // of static caps
  bool has_headers_ = false;         // each tensor, of flexible and sparse caps
};

}  // namespace weir
