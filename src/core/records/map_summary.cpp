// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/map_summary.hpp"

#include <algorithm>
#include <cmath>

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
  std::vector<uint64_t> cells;  // of each class, up to the greatest that occurs: 65535 at most
  uint64_t all = 0;
  for_each_cell(classes.width, classes.height, map, [&](size_t i) {
    const uint32_t index = classes.at(i);
    if (index >= cells.size()) cells.resize(size_t{index} + 1);
    ++cells[index];
    ++all;
  });
  std::vector<ClassPart> out;
  for (uint32_t index = 0; index < cells.size(); ++index)
    if (cells[index] > 0)
      out.push_back({index, static_cast<double>(cells[index]) / static_cast<double>(all)});
  return out;
}

DepthRange range_of_depths(const DepthView& depths, const std::optional<SourceMap>& map) {
  DepthRange out;
  uint64_t count = 0;
  double sum = 0;
  for_each_cell(depths.width, depths.height, map, [&](size_t i) {
    const float depth = depths.at(i);
    if (!std::isfinite(depth)) return;
    out.min = count == 0 ? depth : std::min(out.min, depth);
    out.max = count == 0 ? depth : std::max(out.max, depth);
    sum += depth;
    ++count;
  });
  if (count > 0) out.mean = sum / static_cast<double>(count);
  return out;
}

}  // namespace weir::records
