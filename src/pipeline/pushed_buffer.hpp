// The tensors of a program as one buffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"
#include "weir/abi.h"

namespace weir::pipeline {

// The description in full: shape from the tensor, or of `expected` (may be null) where it has none.
// SPEC_MISMATCH, FRAME_SIZE, LIMIT_EXCEEDED; `index` for the words.
Result<TensorSpec> pushed_spec(const weir_tensor& tensor, const TensorSpec* expected, size_t index);

// One memory for each tensor, those from the 16th on packed into one; with headers when flexible.
// Bytes are copied.
Result<gst::Ref<GstBuffer>> pushed_buffer(std::span<const weir_tensor> tensors,
                                          std::span<const TensorSpec> specs, Format format);

}  // namespace weir::pipeline
