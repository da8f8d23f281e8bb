// HeaderedFrames: frames of a static stream as a flexible stream carries them.
#pragma once
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/frame_pool.hpp"

namespace weir::gst {

// Copies tensors into pooled memory behind a header each: a header must stand directly before its
// payload, so that they cannot be shared. The pool is remade when the tensors change.
class HeaderedFrames {
 public:
  // `in` holds the payloads of `tensors` one after the other, in one memory or several; what comes
  // back has its metadata. The copied bytes are counted. Errors: FRAME_SIZE, OUT_OF_MEMORY.
  Result<Ref<GstBuffer>> copy(GstBuffer* in, const std::vector<TensorSpec>& tensors,
                              MediaType media, Ledger* ledger);
  void clear() { pool_ = {}; }

 private:
  FramePool pool_;
  MediaType media_ = MediaType::Tensor;
};

}  // namespace weir::gst
