// Boxes, key points and labels of detections, drawn on a picture.
//
// Edges go to the nearest boundary of pixels. The line of a box lies within it; a box that is not
// twice as wide as its line is filled. A key point is a disc: with diameter d, in the square of d
// pixels whose middle is nearest to the point, those whose own middle is at most d / 2 away. A
// label is a filled area above the box, or within it where there is no room above, moved into the
// picture; labels are drawn last. Each class has its colour.
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
  uint64_t outside = 0;      // of the picture, with their points and labels
  uint64_t below_score = 0;  // of min_score
};

// `labels`: null for none.
Drawn draw(const Detections& detections, const Style& style, Labels* labels, Canvas* canvas);

}  // namespace weir::draw
