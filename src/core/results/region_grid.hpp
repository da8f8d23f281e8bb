// RegionGrid: which of several numbered regions each cell of a grid over a picture belongs to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <vector>

#include "core/tensor/geometry.hpp"
#include "weir/detection.hpp"

namespace weir::results {

struct RegionGrid {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> numbers;  // row after row
};

// The rows and columns whose centres lie inside a picture, when the grid covers `part` of it.
// `part` becomes what those cover; it is empty if none lies inside.
RegionGrid crop(RegionGrid grid, Size picture, Box* part);

// Appends a mask of size.width * size.height cells over `box`: 255 where the centre of a cell lies
// in a cell of the grid, which covers `part`, whose number is not 0.
void append_mask(const RegionGrid& grid, const Box& part, const Box& box, Size size,
                 std::vector<uint8_t>* masks);

}  // namespace weir::results
