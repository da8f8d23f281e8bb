// The dimension that counts frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/gathered_tensor.hpp"

#include <string>

namespace weir {

Result<TensorSpec> gathered_tensor(TensorSpec frame, uint32_t frames) {
  if (frames == 1) return frame;
  const std::string offered = frame.to_string();
  const size_t rank = frame.shape.rank();
  const size_t axis = rank > 1 && frame.shape[rank - 1] == 1 ? rank - 1 : rank;
  if (axis < kRankLimit) {
    frame.shape[axis] = frames;
    if (frame.bytes()) return frame;
  }
  return Error{Code::LIMIT_EXCEEDED,
               "frames of this tensor cannot be gathered",
               offered + ", " + std::to_string(frames) + " times",
               "at most 16 dimensions and 2^63 - 1 bytes",
               "",
               "tensor_converter frames-per-tensor=1"};
}

}  // namespace weir
