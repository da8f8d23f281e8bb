// Gives an output buffer one memory per tensor, with or without headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {

// Returns a buffer with one memory per tensor: `in` itself if its memories match, else one that
// shares with it; otherwise its memories are merged first, counted as copied. More than 16 tensors
// stay in one memory. Metadata is copied.
Result<gst::Ref<GstBuffer>> one_memory_each(gst::Ref<GstBuffer> in,
                                            const std::vector<TensorSpec>& tensors, Ledger* ledger);

// Copies each tensor into pooled memory after its header: a header must directly precede its
// payload, so tensors cannot be shared. A change of the tensors makes a new pool.
class HeaderedFrames {
 public:
  // `in` holds the payloads of `tensors` in order, in one memory or several. The result has its
  // metadata. Copied bytes are counted. Errors: FRAME_SIZE, MAPPING_FAILED, OUT_OF_MEMORY.
  Result<gst::Ref<GstBuffer>> copy(GstBuffer* in, const std::vector<TensorSpec>& tensors,
                                   MediaType media, Ledger* ledger);
  void clear() { pool_ = {}; }

 private:
  gst::FramePool pool_;
  MediaType media_ = MediaType::Tensor;
};

}  // namespace weir
