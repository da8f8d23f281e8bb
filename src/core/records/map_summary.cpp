// Goes through the cells of maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/map_summary.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace weir::records {
namespace {

// Calls visit(index) for each cell in the picture.
template <class Visit>
void for_each_cell(uint32_t width, uint32_t height, const std::optional<SourceMap>& map,
                   Visit visit) {
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      if (map) {
        const Point at = map->to_source({x + 0.5, y + 0.5});
        if (!(at.x >= 0 && at.y >= 0 && at.x < map->source_width && at.y < map->source_height))
          continue;
      }
      visit(size_t{y} * width + x);
    }
}

}  // namespace

std::vector<ClassPart> parts_of_classes(const ClassMapView& classes,
                                        const std::optional<SourceMap>& map) {
  std::map<uint32_t, uint64_t> cells;
  uint64_t all = 0;
  for_each_cell(classes.width, classes.height, map, [&](size_t i) {
    ++cells[classes.at(i)];
    ++all;
  });
  std::vector<ClassPart> out;
  out.reserve(cells.size());
  for (const auto& [index, count] : cells)
    out.push_back({index, static_cast<double>(count) / static_cast<double>(all)});
  return out;
}

DepthRange range_of_depths(const DepthView& depths, const std::optional<SourceMap>& map) {
  DepthRange out;
  uint64_t count = 0;
  double sum = 0;
  for_each_cell(depths.width, depths.height, map, [&](size_t i) {
    const float depth = depths.at(i);
    if (!std::isfinite(depth)) return;
    out.least = count == 0 ? depth : std::min(out.least, depth);
    out.greatest = count == 0 ? depth : std::max(out.greatest, depth);
    sum += depth;
    ++count;
  });
  if (count > 0) out.mean = sum / static_cast<double>(count);
  return out;
}

}  // namespace weir::records
