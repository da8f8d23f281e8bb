// How a zone looks on a picture: its outline, and its name with what was counted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "core/draw/canvas.hpp"
#include "core/draw/detections.hpp"

namespace weir::draw {

// The outline of an area, or a line with an arrow from its middle in the forward direction.
// `points` are on the canvas.
void draw_zone(zone::Kind kind, std::span<const Point> points, double width, const Paint& paint,
               Canvas* canvas) noexcept;

// "yard: 2 inside, 5 entered", "gate: 3 forward, 1 backward"; only the name if nothing is known.
std::string text_of_zone(const zone::Zone& zone, const ZoneTotal& total);

}  // namespace weir::draw
