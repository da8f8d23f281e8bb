// Regions: parts to cut from a tensor, as given by another tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/preprocess/boxes.hpp"
#include "core/tensor/frame_spec.hpp"
#include "core/tensor/geometry.hpp"
#include "core/tensor/strided_layout.hpp"
#include "weir/source_map.hpp"

namespace weir {

struct Regions {
  std::vector<Rect> inside;    // at most kTensorLimit
  std::vector<uint64_t> rows;  // of results, plus 1, for each region; empty for plain numbers
  uint64_t empty = 0;          // entirely outside, or not a finite number
  uint64_t beyond_limit = 0;
};
// Reads groups of four numbers of any type (x, y, width, height), clipped to `width` x `height`.
// Ignores an incomplete last group. Precondition: the payload has the spec's size.
Regions read_regions(const TensorSpec& spec, std::span<const std::byte> payload, uint32_t width,
                     uint32_t height);

// The same for boxes of results, which `map` moves from pixels of the source picture to those of
// the tensor. A box that the map rotates becomes the upright one around it. Precondition:
// check_picture_dimensions().
Regions read_regions(std::span<const preprocess::PictureBox> boxes, const SourceMap& map,
                     uint32_t width, uint32_t height);
// SPEC_MISMATCH: x and y of the picture are not dimensions 1 and 2 of the tensor, which are cut.
Status check_picture_dimensions(const SourceMap& map);

// The part of a tensor channels:width:height. Omits dimensions from the fourth on; missing ones are
// 1.
TensorSpec make_part_spec(const TensorSpec& whole, const Rect& region);
// The part's layout in the memory of the whole tensor. Precondition: the region is inside.
StridedLayout make_layout(const TensorSpec& whole, const Rect& region);
// Copies the part. Preconditions: the region is inside; `in` and `out` have the sizes of the specs.
void cut(const TensorSpec& whole, std::span<const std::byte> in, const Rect& region,
         std::span<std::byte> out);

}  // namespace weir
