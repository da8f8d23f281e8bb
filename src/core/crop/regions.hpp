// Regions: where a tensor is cut, as another tensor says; and the cut.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "core/tensor/strided_layout.hpp"

namespace weir {

struct Region {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Region&) const = default;
};

struct Regions {
  std::vector<Region> inside;  // at most kTensorLimit
  uint64_t empty = 0;          // nothing of it lies inside, or a number of it is none
  uint64_t beyond_limit = 0;
};
// Groups of four numbers of any type: x, y, width, height, cut to `width` times `height`. What is
// left behind the last whole group is not read. Precondition: the payload has the spec's size.
Regions read_regions(const TensorSpec& spec, std::span<const std::byte> payload, uint32_t width,
                     uint32_t height);

// Of a tensor channels:width:height, dimensions from the fourth on left out; missing ones are 1.
TensorSpec part_of(const TensorSpec& whole, const Region& region);
// Where the part lies in the memory of the whole tensor. Precondition: the region lies inside.
StridedLayout layout_of(const TensorSpec& whole, const Region& region);
// Preconditions: the region lies inside; `in` and `out` have the sizes of the specs.
void cut(const TensorSpec& whole, std::span<const std::byte> in, const Region& region,
         std::span<std::byte> out);

}  // namespace weir
