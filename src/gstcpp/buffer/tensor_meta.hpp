// WeirTensorMeta: metadata of a buffer's tensors beyond caps and headers (source maps).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "weir/abi.h"
#include "weir/source_map.hpp"

namespace weir::gst {

enum class MapsOf : uint8_t {
  Tensors,  // one for all tensors, or one for each
  Regions,  // of batches: one per index of the outermost dimension, for every tensor
};

// The transforms from tensor to source picture coordinates; empty when the buffer has none. Valid
// until the buffer is changed or released.
std::span<const SourceMap> source_maps(GstBuffer* buffer) noexcept;
MapsOf maps_of(GstBuffer* buffer) noexcept;

// The source maps of a buffer in the form that modules take. One frame at a time.
class FrameMaps {
 public:
  // Fills `frame` with the maps of the buffer's tensors, or of the `chosen` ones unless that is
  // empty. The frame borrows them until the next call.
  void fill(GstBuffer* buffer, std::span<const size_t> chosen, weir_frame* frame);

 private:
  std::vector<weir_source_map> maps_;
};

// Replaces the maps of a writable buffer; an empty vector removes them.
void set_source_maps(GstBuffer* buffer, std::vector<SourceMap> maps, MapsOf of = MapsOf::Tensors);

}  // namespace weir::gst
