// stacked_tensor: the tensor of several consecutive frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/tensor/frame_spec.hpp"

namespace weir {

// The tensor of `frames` consecutive frames, counted by the outermost dimension as for video and
// audio. An outermost dimension of 1 is reused ("3:4:5:1" becomes "3:4:5:2"); otherwise one is
// appended ("3" becomes "3:2"). A single frame is unchanged. LIMIT_EXCEEDED above 16 dimensions or
// a size of 63 bits.
Result<TensorSpec> stacked_tensor(TensorSpec frame, uint32_t frames);

}  // namespace weir
