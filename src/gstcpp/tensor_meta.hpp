// WeirTensorMeta: what a buffer says of its tensors beyond caps and headers.
#pragma once
#include <gst/gst.h>

#include <array>
#include <span>
#include <vector>

#include "weir/picture_map.hpp"

namespace weir::gst {

enum class MapsOf : uint8_t {
  Tensors,  // one for all tensors, or one for each
  Regions,  // of batches: one for each index of the outermost dimension, of every tensor
};

// The ways back into the source picture. Empty when the buffer has none. Valid while the buffer is
// neither changed nor released.
std::span<const PictureMap> picture_maps(GstBuffer* buffer) noexcept;
MapsOf maps_of(GstBuffer* buffer) noexcept;

// That of one tensor, of a batch the first region's, as modules see it (weir_frame's to_source),
// written to `values`; null = none.
const float* to_source(GstBuffer* buffer, size_t tensor, std::array<float, 6>* values) noexcept;

// Replaces them. `buffer` is writable; empty takes them away.
void set_picture_maps(GstBuffer* buffer, std::vector<PictureMap> maps, MapsOf of = MapsOf::Tensors);

}  // namespace weir::gst
