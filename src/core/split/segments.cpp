// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/split/segments.hpp"

#include <algorithm>
#include <string>

#include "core/split/pick_list.hpp"
#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir {
namespace {

Error unreadable(std::string_view text, size_t segment, std::string_view part) {
  return Error{.code = Code::DIMENSION_SYNTAX,
               .what = "segment " + std::to_string(segment) + " of tensorseg cannot be read",
               .offered = "tensorseg=" + std::string(text),
               .needed =
                   "whole numbers above 0 from the innermost dimension outwards, separated by ':'; "
                   "',' between segments; at most 16 dimensions",
               .difference = place_in(text, static_cast<size_t>(part.data() - text.data())),
               .fix = "tensorseg=3:4:1,3:4:2"};
}

SourceMap crop_map(const SourceMap& map, const Segment::Part& part) {
  if (part.dimension == map.x_dimension)
    return map.of_part(1, part.from, 1, 0, part.extent, map.height);
  if (part.dimension == map.y_dimension)
    return map.of_part(1, 0, 1, part.from, map.width, part.extent);
  return map;
}

}  // namespace

Result<std::vector<Shape>> parse_segments(std::string_view text) {
  std::vector<Shape> out;
  if (strip(text).empty()) return out;
  for (const auto segment : split(text, kPickSeparators)) {
    Shape shape;
    size_t rank = 0;
    bool ended = false;  // by a 0, like dimensions in headers
    for (const auto raw : split(segment, ":")) {
      const auto part = strip(raw);
      const auto extent = parse_unsigned(part);
      if (!extent || *extent > UINT32_MAX || rank == kRankLimit || (ended && *extent > 0))
        return unreadable(text, out.size(), part.empty() ? raw : part);
      ended = *extent == 0;
      shape[rank++] = static_cast<uint32_t>(*extent);
    }
    if (!shape.valid()) return unreadable(text, out.size(), segment);
    out.push_back(shape);
  }
  return out;
}

std::vector<SourceMap> make_source_maps(const Segment& segment, const TensorSpec& input,
                                        std::span<const SourceMap> maps, bool of_regions) {
  std::vector<SourceMap> out;
  if (!segment.part) return out;
  const Segment::Part& part = *segment.part;
  if (of_regions && part.dimension + 1 == input.shape.rank()) {
    // A batch may have room for more regions than there are.
    const size_t from = std::min<size_t>(part.from, maps.size());
    const auto own = maps.subspan(from, std::min<size_t>(part.extent, maps.size() - from));
    return {own.begin(), own.end()};
  }
  for (const auto& map : maps) out.push_back(crop_map(map, part));
  return out;
}

}  // namespace weir
