// Converts a program's tensors to one buffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"

namespace weir::pipeline {

// The complete spec: the tensor's shape, or that of `expected` (may be null) if it has none.
// SPEC_MISMATCH, FRAME_SIZE, LIMIT_EXCEEDED; `index` is for the error text.
Result<TensorSpec> pushed_spec(const weir_tensor& tensor, const TensorSpec* expected, size_t index);

// Copies each tensor into one memory, with headers if flexible; of more than 16, the 16th and all
// later ones are packed into one.
Result<gst::Ref<GstBuffer>> pushed_buffer(std::span<const weir_tensor> tensors,
                                          std::span<const TensorSpec> specs, Format format);

// The bytes of a picture in rows without padding, plane by plane; 0 for formats whose pixels do not
// have whole bytes.
size_t picture_bytes_without_padding(const GstVideoInfo& video);
// Copies such a picture into rows with GStreamer's padding.
Result<gst::Ref<GstBuffer>> padded_picture(const std::byte* bytes, const GstVideoInfo& video);

}  // namespace weir::pipeline
