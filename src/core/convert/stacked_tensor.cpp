// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/stacked_tensor.hpp"

#include <string>

namespace weir {

Result<TensorSpec> stacked_tensor(TensorSpec frame, uint32_t frames) {
  if (frames == 1) return frame;
  const std::string offered = frame.to_string();
  const size_t rank = frame.shape.rank();
  const size_t axis = rank > 1 && frame.shape[rank - 1] == 1 ? rank - 1 : rank;
  if (axis < kRankLimit) {
    frame.shape[axis] = frames;
    if (frame.bytes()) return frame;
  }
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "frames of this tensor cannot be combined",
               .offered = offered + ", " + std::to_string(frames) + " times",
               .needed = "at most 16 dimensions and 2^63 - 1 bytes",
               .fix = "tensor_converter frames-per-tensor=1"};
}

}  // namespace weir
