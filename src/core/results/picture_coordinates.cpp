// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/picture_coordinates.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace weir::results {
namespace {

// Returns as many elements along each side as the turned grid has in that direction.
Size rotated_size(const SourceMap& map, Size grid) noexcept {
  const double length = std::hypot(map.xx, map.yx);
  if (!(length > 0) || !std::isfinite(length)) return grid;
  const double along = std::abs(map.xx) / length, across = std::abs(map.yx) / length;
  const auto count = [&](double x, double y) {
    return static_cast<uint32_t>(std::max(1., x * grid.width + y * grid.height + 0.5));
  };
  return {count(along, across), count(across, along)};
}

// The probability between the centres of a mask's elements; those at the edge beyond them.
uint8_t value_at(const uint8_t* mask, Size size, const Point& place) noexcept {
  const double x = std::clamp(place.x - 0.5, 0., size.width - 1.);
  const double y = std::clamp(place.y - 0.5, 0., size.height - 1.);
  const auto left = static_cast<size_t>(x), top = static_cast<size_t>(y);
  const size_t right = std::min<size_t>(left + 1, size.width - 1);
  const size_t bottom = std::min<size_t>(top + 1, size.height - 1);
  const double over = x - static_cast<double>(left), down = y - static_cast<double>(top);
  const auto in_row = [&](size_t row) {
    const uint8_t* const values = mask + row * size.width;
    return values[left] * (1 - over) + values[right] * over;
  };
  return static_cast<uint8_t>(std::lround(in_row(top) * (1 - down) + in_row(bottom) * down));
}

// Masks over the upright boxes around the objects' boxes, which are those of the tensor.
void turn_masks(const SourceMap& map, FrameResults* results) {
  const Size before{results->mask_width, results->mask_height};
  const size_t bytes = size_t{before.width} * before.height;
  std::vector<uint8_t> turned;
  Size after = before;
  for (size_t i = 0; i < results->objects.size(); ++i) {
    const RotatedGrid grid(map, results->objects[i].box, before);
    const uint8_t* const mask = results->masks.data() + i * bytes;
    after = grid.size();
    for (uint32_t row = 0; row < after.height; ++row)
      for (uint32_t column = 0; column < after.width; ++column) {
        const auto place = grid.find_point(column, row);
        turned.push_back(place ? value_at(mask, before, *place) : uint8_t{0});
      }
  }
  results->masks = std::move(turned);
  results->mask_width = after.width;
  results->mask_height = after.height;
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

bool keeps_directions(const SourceMap& map) noexcept {
  return map.xy == 0 && map.yx == 0 && map.xx > 0 && map.yy > 0;
}

Box upright_box(const SourceMap& map, const Box& box) noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double left = kInfinity, top = kInfinity, right = -kInfinity, bottom = -kInfinity;
  for (const double x : {box.x1, box.x2})
    for (const double y : {box.y1, box.y2}) {
      const Point corner = map.to_source({x, y});
      left = std::min(left, corner.x), right = std::max(right, corner.x);
      top = std::min(top, corner.y), bottom = std::max(bottom, corner.y);
    }
  return {static_cast<float>(left), static_cast<float>(top), static_cast<float>(right),
          static_cast<float>(bottom)};
}

RotatedGrid::RotatedGrid(const SourceMap& map, const Box& box, Size grid) noexcept
    : map_(map),
      box_(box),
      upright_(upright_box(map, box)),
      grid_(grid),
      size_(rotated_size(map, grid)) {}

std::optional<Point> RotatedGrid::find_point(uint32_t column, uint32_t row) const noexcept {
  const Point at = map_.to_tensor({upright_.x1 + (column + 0.5) / size_.width * upright_.width(),
                                   upright_.y1 + (row + 0.5) / size_.height * upright_.height()});
  const double x = (at.x - box_.x1) / box_.width() * grid_.width;
  const double y = (at.y - box_.y1) / box_.height() * grid_.height;
  // False for numbers that are not finite, too.
  if (!(x >= 0 && y >= 0 && x < grid_.width && y < grid_.height)) return std::nullopt;
  return Point{x, y};
}

Object make_object(const detection::Candidate& candidate, bool is_rotated) noexcept {
  const float x = is_rotated ? candidate.x - candidate.width / 2 : candidate.x;
  const float y = is_rotated ? candidate.y - candidate.height / 2 : candidate.y;
  return {.box = {x, y, x + candidate.width, y + candidate.height},
          .score = candidate.score,
          .class_index = std::max(candidate.class_index, 0),
          .rotation = candidate.angle};
}

void move_to_picture(const SourceMap& map, bool is_rotated, FrameResults* results) {
  if (!is_rotated && !results->masks.empty() && !keeps_directions(map)) turn_masks(map, results);
  for (Object& object : results->objects) {
    if (is_rotated)
      move_rotated(map, &object);
    else
      object.box = upright_box(map, object.box);
  }
  for (KeyPoint& point : results->points) {
    const Point moved = map.to_source({point.x, point.y});
    point.x = static_cast<float>(moved.x);
    point.y = static_cast<float>(moved.y);
  }
}

}  // namespace weir::results
