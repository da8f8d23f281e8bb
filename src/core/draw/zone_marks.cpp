// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/zone_marks.hpp"

#include <cmath>

#include "core/draw/lines.hpp"

namespace weir::draw {
namespace {

std::string format_count(float count) {
  constexpr float kMax = 1e15f;
  return count >= 0 && count < kMax ? std::to_string(static_cast<int64_t>(count)) : "?";
}

}  // namespace

void draw_zone(zone::Kind kind, std::span<const Point> points, double width, const Paint& paint,
               Canvas* canvas) noexcept {
  if (kind == zone::Kind::Area) return draw_outline(points, width, paint, canvas);
  const Point a = points[0], b = points[1];
  draw_line(a, b, width, paint, canvas);
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  if (!(length > 0)) return;
  // Forward is to the right of the direction from a to b, where y points down.
  const double size = 5 * width, x = -(b.y - a.y) / length, y = (b.x - a.x) / length;
  const Point middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
  const Point neck{middle.x + size * x, middle.y + size * y};
  draw_line(middle, neck, width, paint, canvas);
  const Point head[] = {{neck.x + size * x, neck.y + size * y},
                        {neck.x + size * y * 0.7, neck.y - size * x * 0.7},
                        {neck.x - size * y * 0.7, neck.y + size * x * 0.7}};
  fill_convex(head, paint, canvas);
}

std::string text_of_zone(const zone::Zone& zone, const ZoneTotal& total) {
  if (zone.kind == zone::Kind::Area) {
    if (std::isnan(total.inside)) return zone.name;
    return zone.name + ": " + format_count(total.inside) + " inside, " +
           format_count(total.entered) + " entered";
  }
  if (std::isnan(total.forward)) return zone.name;
  return zone.name + ": " + format_count(total.forward) + " forward, " +
         format_count(total.backward) + " backward";
}

}  // namespace weir::draw
