// Converts coverage of pixels to coverage of bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/mask.hpp"

namespace weir::draw {
namespace {

uint8_t mean_of_four(const Mask& mask, uint32_t x, uint32_t y) {
  unsigned sum = 2;
  for (uint32_t row = y; row < y + 2 && row < mask.height; ++row)
    for (uint32_t column = x; column < x + 2 && column < mask.width; ++column)
      sum += mask.coverage[size_t{row} * mask.width + column];
  return static_cast<uint8_t>(sum / 4);
}

}  // namespace

PlaneMask for_planes(const Mask& mask, const preprocess::PictureFormat& format) {
  PlaneMask out;
  out.width = mask.width;
  out.height = mask.height;
  for (size_t i = 0; i < format.lane_count(); ++i) {
    const preprocess::Lane& lane = format.lanes[i];
    PlaneMask::Plane& plane = out.planes[lane.plane];
    if (!plane.coverage.empty()) continue;  // the lanes of a plane are equal
    const uint32_t every = lane.halved ? 2 : 1;
    plane.row_bytes = size_t{(mask.width + every - 1) / every} * lane.step;
    for (uint32_t y = 0; y < mask.height; y += every)
      for (uint32_t x = 0; x < mask.width; x += every) {
        const uint8_t covered =
            lane.halved ? mean_of_four(mask, x, y) : mask.coverage[size_t{y} * mask.width + x];
        plane.coverage.insert(plane.coverage.end(), lane.step, covered);
      }
  }
  return out;
}

}  // namespace weir::draw
