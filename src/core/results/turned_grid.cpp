// Computes upright boxes and the places of turned elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/turned_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weir::results {
namespace {

// As many elements along each side as the turned grid has in that direction.
GridSize turned_size(const SourceMap& map, GridSize grid) noexcept {
  const double length = std::hypot(map.xx, map.yx);
  if (!(length > 0) || !std::isfinite(length)) return grid;
  const double along = std::abs(map.xx) / length, across = std::abs(map.yx) / length;
  const auto count = [&](double x, double y) {
    return static_cast<uint32_t>(std::max(1., x * grid.width + y * grid.height + 0.5));
  };
  return {count(along, across), count(across, along)};
}

}  // namespace

bool keeps_directions(const SourceMap& map) noexcept {
  return map.xy == 0 && map.yx == 0 && map.xx > 0 && map.yy > 0;
}

Box upright_box(const SourceMap& map, const Box& box) noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double left = kInfinity, top = kInfinity, right = -kInfinity, bottom = -kInfinity;
  for (const double x : {box.x1, box.x2})
    for (const double y : {box.y1, box.y2}) {
      const Point corner = map.to_source({x, y});
      left = std::min(left, corner.x), right = std::max(right, corner.x);
      top = std::min(top, corner.y), bottom = std::max(bottom, corner.y);
    }
  return {static_cast<float>(left), static_cast<float>(top), static_cast<float>(right),
          static_cast<float>(bottom)};
}

TurnedGrid::TurnedGrid(const SourceMap& map, const Box& box, GridSize grid) noexcept
    : map_(map),
      box_(box),
      upright_(upright_box(map, box)),
      grid_(grid),
      size_(turned_size(map, grid)) {}

std::optional<Point> TurnedGrid::place_of(uint32_t column, uint32_t row) const noexcept {
  const Point at = map_.to_tensor({upright_.x1 + (column + 0.5) / size_.width * upright_.width(),
                                   upright_.y1 + (row + 0.5) / size_.height * upright_.height()});
  const double x = (at.x - box_.x1) / box_.width() * grid_.width;
  const double y = (at.y - box_.y1) / box_.height() * grid_.height;
  // False for numbers that are not finite, too.
  if (!(x >= 0 && y >= 0 && x < grid_.width && y < grid_.height)) return std::nullopt;
  return Point{x, y};
}

}  // namespace weir::results
