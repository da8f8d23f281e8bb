// WeirTensorMeta: what a buffer says of its tensors beyond caps and headers.
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "weir/abi.h"
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

// The maps of a buffer as modules get them. One frame at a time.
class FrameMaps {
 public:
  // Fills `frame` with those of the buffer's tensors, or of `chosen` tensors where it is not empty.
  // The frame borrows them until the next call.
  void fill(GstBuffer* buffer, std::span<const size_t> chosen, weir_frame* frame);

 private:
  std::vector<weir_picture_map> maps_;
};

// Replaces them. `buffer` is writable; empty takes them away.
void set_picture_maps(GstBuffer* buffer, std::vector<PictureMap> maps, MapsOf of = MapsOf::Tensors);

}  // namespace weir::gst
