// Maps boxes, angles and key points to the source picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/to_picture.hpp"

#include <algorithm>
#include <cmath>

namespace weir::results {
namespace {

Box upright_box(const SourceMap& map, const Box& box) noexcept {
  double left = INFINITY, top = INFINITY, right = -INFINITY, bottom = -INFINITY;
  for (const double x : {box.x1, box.x2})
    for (const double y : {box.y1, box.y2}) {
      const Point corner = map.to_source({x, y});
      left = std::min(left, corner.x), right = std::max(right, corner.x);
      top = std::min(top, corner.y), bottom = std::max(bottom, corner.y);
    }
  return {static_cast<float>(left), static_cast<float>(top), static_cast<float>(right),
          static_cast<float>(bottom)};
}

// The map turns the direction of the box's width and stretches its sides. Where it stretches x and
// y differently, the result is the rectangle with the two mapped sides' lengths and the mapped
// direction of the width.
void move_rotated(const SourceMap& map, Object* object) noexcept {
  const Box& box = object->box;
  const double c = std::cos(object->rotation), s = std::sin(object->rotation);
  const Point centre = map.to_source({(box.x1 + box.x2) / 2.0, (box.y1 + box.y2) / 2.0});
  const Point along{map.xx * c + map.xy * s, map.yx * c + map.yy * s};
  const Point across{-map.xx * s + map.xy * c, -map.yx * s + map.yy * c};
  const double half_width = box.width() * std::hypot(along.x, along.y) / 2;
  const double half_height = box.height() * std::hypot(across.x, across.y) / 2;
  object->rotation = static_cast<float>(std::atan2(along.y, along.x));
  object->box = {
      static_cast<float>(centre.x - half_width), static_cast<float>(centre.y - half_height),
      static_cast<float>(centre.x + half_width), static_cast<float>(centre.y + half_height)};
}

}  // namespace

Object object_of(const detection::Candidate& candidate, bool is_rotated) noexcept {
  const float x = is_rotated ? candidate.x - candidate.width / 2 : candidate.x;
  const float y = is_rotated ? candidate.y - candidate.height / 2 : candidate.y;
  return {.box = {x, y, x + candidate.width, y + candidate.height},
          .score = candidate.score,
          .class_index = std::max(candidate.class_index, 0),
          .rotation = candidate.angle};
}

void move_to_picture(const SourceMap& map, bool is_rotated, Answer* answer) noexcept {
  for (Object& object : answer->objects) {
    if (is_rotated)
      move_rotated(map, &object);
    else
      object.box = upright_box(map, object.box);
  }
  for (KeyPoint& point : answer->points) {
    const Point moved = map.to_source({point.x, point.y});
    point.x = static_cast<float>(moved.x);
    point.y = static_cast<float>(moved.y);
  }
}

}  // namespace weir::results
