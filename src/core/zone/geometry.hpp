// Geometry of zones: points of a box, polygons, crossed lines, and pixels as metres on the ground.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <optional>
#include <span>

#include "core/tensor/geometry.hpp"
#include "weir/detection.hpp"
#include "weir/source_map.hpp"

namespace weir::zone {

// Which point of a box says where the object is.
enum class Reference { Bottom, Centre, Top };
inline constexpr size_t kReferences = 3;

// Bottom and Top are the middle of that edge. `rotation` turns the box about its centre, clockwise,
// in radians.
Point reference_point(const Box& box, float rotation, Reference reference) noexcept;

// The point within a picture of this size that is nearest to `at`, if a part of the box is in the
// picture; otherwise `at`. Detectors extend boxes beyond the picture, where no zone can be.
Point move_into(Size picture, const Box& box, Point at) noexcept;
// Whether the line lies on an edge of the picture or outside of it, where no point of move_into()
// can cross it.
bool is_on_edge(Size picture, Point a, Point b) noexcept;

// Whether a polygon contains the point, by the even-odd rule: where a polygon overlaps itself, a
// part that is covered twice is outside. Of upright edges, the left and the upper ones are inside,
// so that a point between two areas that touch is in exactly one.
bool contains(std::span<const Point> polygon, Point at) noexcept;

enum class Crossing { None, Forward, Backward };
// Whether a move crosses the line from `a` to `b`. Forward: to the right-hand side of someone who
// stands at `a` and looks to `b`, as seen in the picture. A point on the line is on the right-hand
// side. The line includes `a` and not `b`, so that a move through an end that two lines share
// crosses exactly one.
Crossing crossing(Point a, Point b, Point from, Point to) noexcept;

// The shortest distance from a point to the line between two points.
double distance_to_line(Point a, Point b, Point at) noexcept;
// The same to the nearest side of a polygon, from inside or outside.
double distance_to_outline(std::span<const Point> polygon, Point at) noexcept;

// A projective map (homography) from pixels to metres on the ground.
class Ground {
 public:
  explicit Ground(double metres_per_pixel) noexcept;
  // From four points of the picture to four points of the ground; nullopt if three of either lie on
  // a line.
  static std::optional<Ground> from_points(const std::array<Point, 4>& picture,
                                           const std::array<Point, 4>& metres) noexcept;
  // nullopt on or beyond the horizon: the side on which the four points are not.
  std::optional<Point> to_metres(Point pixel) const noexcept;

 private:
  Ground() = default;
  std::array<double, 9> matrix_{};  // row after row; positive third coordinate before the horizon
};

}  // namespace weir::zone
