// WeirTensorMeta: what a buffer says of its tensors beyond caps and headers.
#pragma once
#include <gst/gst.h>

#include <array>
#include <span>
#include <vector>

#include "weir/picture_map.hpp"

namespace weir::gst {

// The ways back into the source picture: one for all tensors, or one for each; or of one tensor
// that is a batch of regions, one for each index of its outermost dimension. Empty when the
// buffer has none. Valid while the buffer is neither changed nor released.
std::span<const PictureMap> picture_maps(GstBuffer* buffer) noexcept;

// The first of them as modules see it (weir_frame's to_source), written to `values`; null = none.
const float* to_source(GstBuffer* buffer, std::array<float, 6>* values) noexcept;

// Replaces them. `buffer` is writable; empty takes them away.
void set_picture_maps(GstBuffer* buffer, std::vector<PictureMap> maps);

}  // namespace weir::gst
