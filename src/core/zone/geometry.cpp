// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/zone/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace weir::zone {
namespace {

// Above 0: `p` is to the right of the direction from `a` to `b`, where y points down.
double get_side(Point a, Point b, Point p) noexcept {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

constexpr size_t kUnknowns = 8;
using Equations = std::array<std::array<double, kUnknowns + 1>, kUnknowns>;

// The row from `first` on whose number in the column `first` is the largest.
size_t pivot_row(const Equations& rows, size_t first) noexcept {
  size_t pivot = first;
  for (size_t row = first + 1; row < kUnknowns; ++row)
    if (std::abs(rows[row][first]) > std::abs(rows[pivot][first])) pivot = row;
  return pivot;
}

// Gaussian elimination with partial pivoting; false if the equations have no single solution.
bool solve(Equations* equations, std::array<double, kUnknowns>* out) noexcept {
  Equations& rows = *equations;
  for (size_t i = 0; i < kUnknowns; ++i) {
    std::swap(rows[i], rows[pivot_row(rows, i)]);
    if (!(std::abs(rows[i][i]) > 1e-12)) return false;
    for (size_t row = i + 1; row < kUnknowns; ++row) {
      const double factor = rows[row][i] / rows[i][i];
      for (size_t column = i; column <= kUnknowns; ++column)
        rows[row][column] -= factor * rows[i][column];
    }
  }
  for (size_t i = kUnknowns; i-- > 0;) {
    double sum = rows[i][kUnknowns];
    for (size_t column = i + 1; column < kUnknowns; ++column)
      sum -= rows[i][column] * (*out)[column];
    (*out)[i] = sum / rows[i][i];
  }
  return true;
}

// Whether no three of the points lie on a line, relative to their distances.
bool span_a_plane(const std::array<Point, 4>& points) noexcept {
  for (size_t left_out = 0; left_out < 4; ++left_out) {
    const Point a = points[(left_out + 1) % 4], b = points[(left_out + 2) % 4],
                c = points[(left_out + 3) % 4];
    const double lengths = std::hypot(b.x - a.x, b.y - a.y) * std::hypot(c.x - a.x, c.y - a.y);
    if (!(std::abs(get_side(a, b, c)) > 1e-9 * lengths)) return false;
  }
  return true;
}

// Moves the centre of the points to 0 and their extent to 1, which keeps the equations well
// conditioned: point = centre + extent * scaled.
struct Scaling {
  double x = 0, y = 0, extent = 1;
  explicit Scaling(const std::array<Point, 4>& points) noexcept {
    for (const Point& p : points) x += p.x / 4, y += p.y / 4;
    double largest = 0;
    for (const Point& p : points)
      largest = std::max({largest, std::abs(p.x - x), std::abs(p.y - y)});
    extent = largest;
  }
  Point apply(Point p) const noexcept { return {(p.x - x) / extent, (p.y - y) / extent}; }
};

}  // namespace

Point reference_point(const Box& box, float rotation, Reference reference) noexcept {
  const double x = (double{box.x1} + box.x2) / 2, y = (double{box.y1} + box.y2) / 2;
  double half = (double{box.y2} - box.y1) / 2;
  if (reference == Reference::Centre) half = 0;
  if (reference == Reference::Top) half = -half;
  if (rotation == 0) return {x, y + half};
  return {x - half * std::sin(double{rotation}), y + half * std::cos(double{rotation})};
}

Point move_into(Size picture, const Box& box, Point at) noexcept {
  const auto width = static_cast<float>(picture.width), height = static_cast<float>(picture.height);
  if (!(common_part(box, {0, 0, width, height}).area() > 0)) return at;
  // Areas exclude their right and lower edges, which are those of the picture.
  const auto inside = [](double value, double side) {
    return std::clamp(value, 0.0, std::nextafter(side, 0.0));
  };
  return {inside(at.x, width), inside(at.y, height)};
}

bool is_on_edge(Size picture, Point a, Point b) noexcept {
  const auto is_beyond = [](double one, double two, double side) {
    return std::max(one, two) <= 0 || std::min(one, two) >= side;
  };
  return is_beyond(a.x, b.x, picture.width) || is_beyond(a.y, b.y, picture.height);
}

bool contains(std::span<const Point> polygon, Point at) noexcept {
  bool inside = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point a = polygon[i], b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    if ((a.y <= at.y) == (b.y <= at.y)) continue;
    if (a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) > at.x) inside = !inside;
  }
  return inside;
}

Crossing crossing(Point a, Point b, Point from, Point to) noexcept {
  const double before = get_side(a, b, from), after = get_side(a, b, to);
  if ((before >= 0) == (after >= 0)) return Crossing::None;
  const double part = before / (before - after);
  const Point at{from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)};
  const double along = (at.x - a.x) * (b.x - a.x) + (at.y - a.y) * (b.y - a.y);
  const double length = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
  if (!(along >= 0 && along < length)) return Crossing::None;
  return after >= 0 ? Crossing::Forward : Crossing::Backward;
}

double distance_to_line(Point a, Point b, Point at) noexcept {
  const double x = b.x - a.x, y = b.y - a.y, length = x * x + y * y;
  const double part =
      length > 0 ? std::clamp(((at.x - a.x) * x + (at.y - a.y) * y) / length, 0.0, 1.0) : 0;
  return std::hypot(at.x - a.x - part * x, at.y - a.y - part * y);
}

double distance_to_outline(std::span<const Point> polygon, Point at) noexcept {
  double min = INFINITY;
  for (size_t i = 0; i < polygon.size(); ++i)
    min = std::min(min,
                   distance_to_line(polygon[i], polygon[i + 1 < polygon.size() ? i + 1 : 0], at));
  return min;
}

Ground::Ground(double metres_per_pixel) noexcept
    : matrix_{metres_per_pixel, 0, 0, 0, metres_per_pixel, 0, 0, 0, 1} {}

std::optional<Ground> Ground::from_points(const std::array<Point, 4>& picture,
                                          const std::array<Point, 4>& metres) noexcept {
  if (!span_a_plane(picture) || !span_a_plane(metres)) return std::nullopt;
  const Scaling from(picture), to(metres);
  Equations equations{};
  for (size_t i = 0; i < 4; ++i) {
    const Point p = from.apply(picture[i]), q = to.apply(metres[i]);
    equations[2 * i] = {p.x, p.y, 1, 0, 0, 0, -q.x * p.x, -q.x * p.y, q.x};
    equations[2 * i + 1] = {0, 0, 0, p.x, p.y, 1, -q.y * p.x, -q.y * p.y, q.y};
  }
  std::array<double, kUnknowns> h{};
  if (!solve(&equations, &h)) return std::nullopt;
  // to^-1 * h * from: first the scaling of the ground, then that of the picture.
  std::array<std::array<double, 3>, 3> rows{
      {{h[0], h[1], h[2]}, {h[3], h[4], h[5]}, {h[6], h[7], 1}}};
  for (size_t i = 0; i < 3; ++i) {
    rows[0][i] = to.extent * rows[0][i] + to.x * rows[2][i];
    rows[1][i] = to.extent * rows[1][i] + to.y * rows[2][i];
  }
  Ground out;
  for (size_t row = 0; row < 3; ++row) {
    const double x = rows[row][0] / from.extent, y = rows[row][1] / from.extent;
    out.matrix_[3 * row] = x;
    out.matrix_[3 * row + 1] = y;
    out.matrix_[3 * row + 2] = rows[row][2] - x * from.x - y * from.y;
  }
  // The four points must be on one side of the horizon.
  for (const Point& p : picture)
    if (!out.to_metres(p)) return std::nullopt;
  return out;
}

std::optional<Point> Ground::to_metres(Point pixel) const noexcept {
  const auto row = [&](size_t i) {
    return matrix_[3 * i] * pixel.x + matrix_[3 * i + 1] * pixel.y + matrix_[3 * i + 2];
  };
  const double w = row(2);
  if (!(w > 1e-9)) return std::nullopt;
  return Point{row(0) / w, row(1) / w};
}

}  // namespace weir::zone
