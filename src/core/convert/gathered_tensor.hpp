// Several frames of one tensor as one tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/tensor/frame_spec.hpp"

namespace weir {

// The tensor of so many frames behind each other: the outermost dimension counts them, as it does
// for video and audio. It is the one that is there where that is 1 ("3:4:5:1" becomes "3:4:5:2"),
// else one more ("3" becomes "3:2"). A single frame stays as it is. LIMIT_EXCEEDED beyond 16
// dimensions or 63 bits of size.
Result<TensorSpec> gathered_tensor(TensorSpec frame, uint32_t frames);

}  // namespace weir
