// Lines of any direction and width, as filled polygons.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/draw/canvas.hpp"
#include "weir/source_map.hpp"

namespace weir::draw {

// Fills the pixels whose centre is inside a convex polygon, left and upper edges included. Corners
// that are not finite draw nothing.
void fill_convex(std::span<const Point> corners, const Paint& paint, Canvas* canvas) noexcept;

// A line between two points, `width` pixels wide, with its ends square to its direction. At least
// one pixel wide along the steeper axis. A width of 0 draws nothing.
void draw_line(Point from, Point to, double width, const Paint& paint, Canvas* canvas) noexcept;

// The lines between adjacent corners, and from the last to the first.
void draw_outline(std::span<const Point> corners, double width, const Paint& paint,
                  Canvas* canvas) noexcept;

}  // namespace weir::draw
