// HeaderedFrames: converts frames of a static stream to frames of a flexible stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_pool.hpp"

namespace weir::gst {

// Copies each tensor into pooled memory after its header: a header must directly precede its
// payload, so tensors cannot be shared. A change of the tensors makes a new pool.
class HeaderedFrames {
 public:
  // `in` holds the payloads of `tensors` in order, in one memory or several. The result has its
  // metadata. Copied bytes are counted. Errors: FRAME_SIZE, OUT_OF_MEMORY.
  Result<Ref<GstBuffer>> copy(GstBuffer* in, const std::vector<TensorSpec>& tensors,
                              MediaType media, Ledger* ledger);
  void clear() { pool_ = {}; }

 private:
  FramePool pool_;
  MediaType media_ = MediaType::Tensor;
};

}  // namespace weir::gst
