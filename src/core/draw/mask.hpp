// Mask: how much of each pixel a shape covers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/preprocess/picture_format.hpp"

namespace weir::draw {

// One byte per pixel, row after row: 0 is not covered, 255 is fully covered.
struct Mask {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> coverage;
};

// The same for each byte of each plane, so that its rows align with the picture's. The coverage of
// a halved sample is the mean of its two or four pixels, the first of which has an even column and
// row.
struct PlaneMask {
  struct Plane {
    size_t row_bytes = 0;
    std::vector<uint8_t> coverage;
  };
  uint32_t width = 0, height = 0;  // pixels
  std::array<Plane, 3> planes;
};
PlaneMask for_planes(const Mask& mask, const preprocess::PictureFormat& format);

}  // namespace weir::draw
