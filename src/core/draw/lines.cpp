// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace weir::draw {
namespace {

constexpr double kFarPixels = 1e7;  // pixels; corners farther away make no visible difference

bool is_finite(const Point& p) noexcept {
  return std::isfinite(p.x) && std::isfinite(p.y);
}

Point bounded(const Point& p) noexcept {
  return {std::clamp(p.x, -kFarPixels, kFarPixels), std::clamp(p.y, -kFarPixels, kFarPixels)};
}

// The first pixel whose centre is at or after `at`.
int64_t first_pixel(double at) noexcept {
  return static_cast<int64_t>(std::ceil(at - 0.5));
}

}  // namespace

void fill_convex(std::span<const Point> corners, const Paint& paint, Canvas* canvas) noexcept {
  if (corners.size() < 3 || !std::all_of(corners.begin(), corners.end(), is_finite)) return;
  double top = kFarPixels, bottom = -kFarPixels;
  for (const Point& corner : corners) {
    top = std::min(top, bounded(corner).y);
    bottom = std::max(bottom, bounded(corner).y);
  }
  const Area all = canvas->all();
  const int64_t first = std::max(first_pixel(top), all.top);
  const int64_t end = std::min(first_pixel(bottom), all.bottom);
  for (int64_t row = first; row < end; ++row) {
    const double y = static_cast<double>(row) + 0.5;
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Point a = bounded(corners[i]), b = bounded(corners[(i + 1) % corners.size()]);
      if ((a.y <= y) == (b.y <= y)) continue;
      const double x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
      left = std::min(left, x);
      right = std::max(right, x);
    }
    if (left < right) canvas->fill({first_pixel(left), row, first_pixel(right), row + 1}, paint);
  }
}

void draw_line(Point from, Point to, double width, const Paint& paint, Canvas* canvas) noexcept {
  if (!is_finite(from) || !is_finite(to) || !(width > 0)) return;
  from = bounded(from), to = bounded(to);
  const double dx = to.x - from.x, dy = to.y - from.y, length = std::hypot(dx, dy);
  if (!(length > 0)) return;
  // The extent along the axis that crosses the line is width * length / max(|dx|, |dy|).
  const double min = std::max(std::abs(dx), std::abs(dy)) / length;
  const double half = std::max(width, min) / 2 / length;
  const double across_x = -dy * half, across_y = dx * half;
  const std::array<Point, 4> corners{{{from.x + across_x, from.y + across_y},
                                      {to.x + across_x, to.y + across_y},
                                      {to.x - across_x, to.y - across_y},
                                      {from.x - across_x, from.y - across_y}}};
  fill_convex(corners, paint, canvas);
}

void draw_outline(std::span<const Point> corners, double width, const Paint& paint,
                  Canvas* canvas) noexcept {
  for (size_t i = 0; i < corners.size(); ++i)
    draw_line(corners[i], corners[(i + 1) % corners.size()], width, paint, canvas);
}

}  // namespace weir::draw
