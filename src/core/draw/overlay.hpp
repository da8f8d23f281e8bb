// Draws the boxes, key points and labels of detections on a picture.
//
// Edges are rounded to the nearest pixel boundary. A box's line is inside the box; a box less than
// twice as wide as its line is filled. A key point of diameter d is a disc: in the square of d
// pixels centred nearest to the point, the pixels whose centre is at most d / 2 away. A label is a
// filled area above the box, or inside it if there is no room above, moved into the picture. Labels
// are drawn last. Each class has its own colour.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/draw/canvas.hpp"
#include "core/draw/detections.hpp"
#include "core/draw/labels.hpp"

namespace weir::draw {

struct Style {
  uint32_t line_width = 2, point_size = 5;  // pixels; 0 = none
  float min_score = 0;
};

struct Drawn {
  uint64_t boxes = 0;
  uint64_t outside = 0;      // not in the picture; their points and labels are not drawn either
  uint64_t below_score = 0;  // below min_score
};

// `labels` may be null.
Drawn draw(const Detections& detections, const Style& style, Labels* labels, Canvas* canvas);

}  // namespace weir::draw
