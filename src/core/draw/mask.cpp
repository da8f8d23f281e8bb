// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/mask.hpp"

#include <algorithm>

namespace weir::draw {
namespace {

// The mean of the pixels of one sample; pixels beyond the mask count as 0.
uint8_t compute_mean(const Mask& mask, uint32_t x, uint32_t y, uint32_t columns, uint32_t rows) {
  unsigned sum = columns * rows / 2;
  for (uint32_t row = y; row < y + rows && row < mask.height; ++row)
    for (uint32_t column = x; column < x + columns && column < mask.width; ++column)
      sum += mask.coverage[size_t{row} * mask.width + column];
  return static_cast<uint8_t>(sum / (columns * rows));
}

uint32_t pixels(bool is_halved) {
  return is_halved ? 2 : 1;
}

// The component of the plane with the greatest step.
const preprocess::Component& coarsest(const preprocess::PictureFormat& format, uint8_t plane) {
  const preprocess::Component* out = nullptr;
  for (size_t i = 0; i < format.component_count(); ++i) {
    const preprocess::Component& component = format.components[i];
    if (component.plane == plane && (!out || component.step > out->step)) out = &component;
  }
  return *out;
}

// Writes the coverage of one component's bytes; a plane of one grid has a single coverage for all
// bytes of its unit, alpha included.
void write_component(const Mask& mask, const preprocess::Component& component, size_t first,
                     size_t bytes, PlaneMask::Plane* plane) {
  const uint32_t columns = pixels(component.halved_columns), rows = pixels(component.halved_rows);
  uint8_t* row = plane->coverage.data();
  for (uint32_t y = 0; y < mask.height; y += rows, row += plane->row_bytes)
    for (size_t at = first, x = 0; at < plane->row_bytes; at += component.step, x += columns)
      std::fill_n(row + at, bytes, compute_mean(mask, static_cast<uint32_t>(x), y, columns, rows));
}

}  // namespace

PlaneMask for_planes(const Mask& mask, const preprocess::PictureFormat& format) {
  PlaneMask out;
  out.width = mask.width;
  out.height = mask.height;
  for (size_t i = 0; i < format.component_count(); ++i) {
    const preprocess::Component& component = format.components[i];
    const preprocess::Component& unit = coarsest(format, component.plane);
    PlaneMask::Plane& plane = out.planes[component.plane];
    const bool is_first = plane.coverage.empty();
    if (is_first) {
      const uint32_t columns = pixels(unit.halved_columns), rows = pixels(unit.halved_rows);
      plane.row_bytes = size_t{(mask.width + columns - 1) / columns} * unit.step;
      plane.coverage.resize(plane.row_bytes * ((mask.height + rows - 1) / rows));
    }
    if (!component.same_grid(unit) || unit.halved_columns != unit.halved_rows)
      write_component(mask, component, component.offset, 1, &plane);
    else if (is_first)
      write_component(mask, component, 0, component.step, &plane);
  }
  return out;
}

}  // namespace weir::draw
