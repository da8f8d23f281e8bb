// Draws results on a picture: masks, boxes, key points and labels.
//
// Edges of upright boxes are rounded to the nearest pixel boundary. A box's line is inside the box;
// a box less than twice as wide as its line is filled. Rotated boxes are lines along their edges. A
// key point of diameter d is a disc: in the square of d pixels centred nearest to the point, the
// pixels whose centre is at most d / 2 away. Key points of bodies and hands are connected
// (skeleton.hpp). Each class has its own colour.
//
// Class maps are drawn first, then masks, boxes and points, then labels, the best score first: a
// label takes the first free place around its box (label_layout.hpp), and is left out where there
// is none. Labels without a box of their own are a list in the upper left corner of the picture or
// of their parent's box.
//
// Zones are outlines, lines with an arrow in the forward direction, and a label with the name and
// what was counted. They are under the boxes, as trails are.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/draw/canvas.hpp"
#include "core/draw/detections.hpp"
#include "core/draw/labels.hpp"
#include "core/draw/trails.hpp"

namespace weir::draw {

struct Style {
  uint32_t line_width = 2, point_size = 5;  // pixels; 0 = none
  float min_score = 0;
  uint8_t mask_opacity = 115;  // of 255; 0 = no masks
  bool shows_zones = true;
  bool has_track_colors = false;  // a row with a track has the colour of its track, not its class
};

// Sizes in pixels for a picture of this height: 2, 5 and 20 at 720 rows, in proportion.
uint32_t line_width_for(uint32_t height) noexcept;
uint32_t point_size_for(uint32_t height) noexcept;
uint32_t text_size_for(uint32_t height) noexcept;

struct Drawn {
  uint64_t boxes = 0;
  uint64_t outside = 0;      // not in the picture; their points and labels are not drawn either
  uint64_t below_score = 0;  // below min_score
};

// `labels` and `trails` may be null. A trail is drawn for each row whose track has one, in the
// colour of its track.
Drawn draw(const Detections& detections, const Style& style, Labels* labels, Canvas* canvas,
           const Trails* trails = nullptr);

}  // namespace weir::draw
