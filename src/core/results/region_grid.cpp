// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/region_grid.hpp"

#include <cmath>
#include <cstddef>

namespace weir::results {
namespace {

// Of one dimension: a range of cells, and of the picture.
struct Span {
  uint32_t first = 0, last = 0;
  float from = 0, to = 0;
};

Span inside(uint32_t cells, float from, float to, uint32_t side) {
  const double step = (double{to} - from) / cells;
  Span out{0, cells, from, to};
  while (out.first < out.last && !(from + (out.first + 0.5) * step >= 0)) ++out.first;
  while (out.first < out.last && !(from + (out.last - 0.5) * step <= side)) --out.last;
  out.from = static_cast<float>(from + out.first * step);
  out.to = static_cast<float>(from + out.last * step);
  return out;
}

// The cell of the grid under each of `count` cells over a box; -1 = none.
std::vector<int64_t> cells_under(uint32_t count, float from, float to, uint32_t cells,
                                 float part_from, float part_to) {
  std::vector<int64_t> out(count, -1);
  for (uint32_t i = 0; i < count; ++i) {
    const double at = from + (i + 0.5) / count * (double{to} - from);
    const double cell = std::floor((at - part_from) / (double{part_to} - part_from) * cells);
    if (cell >= 0 && cell < cells) out[i] = static_cast<int64_t>(cell);
  }
  return out;
}

}  // namespace

RegionGrid crop(RegionGrid grid, Size picture, Box* part) {
  const Span x = inside(grid.width, part->x1, part->x2, picture.width);
  const Span y = inside(grid.height, part->y1, part->y2, picture.height);
  *part = {x.from, y.from, x.to, y.to};
  RegionGrid out{x.last - x.first, y.last - y.first, {}};
  if (out.width == grid.width && out.height == grid.height) return grid;
  for (uint32_t row = y.first; row < y.last; ++row) {
    const auto start = grid.numbers.begin() + static_cast<ptrdiff_t>(size_t{row} * grid.width);
    out.numbers.insert(out.numbers.end(), start + x.first, start + x.last);
  }
  return out;
}

void append_mask(const RegionGrid& grid, const Box& part, const Box& box, Size size,
                 std::vector<uint8_t>* masks) {
  const auto columns = cells_under(size.width, box.x1, box.x2, grid.width, part.x1, part.x2);
  const auto rows = cells_under(size.height, box.y1, box.y2, grid.height, part.y1, part.y2);
  for (const int64_t row : rows)
    for (const int64_t column : columns) {
      const bool is_inside = row >= 0 && column >= 0;
      const auto at = static_cast<size_t>(row) * grid.width + static_cast<size_t>(column);
      masks->push_back(is_inside && grid.numbers[at] != 0 ? 255 : 0);
    }
}

}  // namespace weir::results
