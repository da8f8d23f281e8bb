// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/object_selection.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "weir/detection.hpp"

namespace weir::results {
namespace {

using detection::Candidate;
using detection::Candidates;

struct Corner {
  double x, y;
};
// A convex polygon; two rectangles have at most 8 corners in common.
struct Polygon {
  std::array<Corner, 16> corners;
  size_t count = 0;
  void add(Corner corner) noexcept {
    if (count < corners.size()) corners[count++] = corner;
  }
};

Polygon to_polygon(const Candidate& box) noexcept {
  const double c = std::cos(box.angle), s = std::sin(box.angle);
  const double w = box.width / 2.0, h = box.height / 2.0;
  Polygon out;
  for (const auto& [x, y] : {Corner{-w, -h}, Corner{w, -h}, Corner{w, h}, Corner{-w, h}})
    out.add({box.x + x * c - y * s, box.y + x * s + y * c});
  return out;
}

double get_area(const Polygon& polygon) noexcept {
  double twice = 0;
  for (size_t i = 0; i < polygon.count; ++i) {
    const Corner &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(twice) / 2;
}

// The part of `polygon` to the right of the edge from `a` to `b` (Sutherland and Hodgman, 1974).
Polygon clip(const Polygon& polygon, Corner a, Corner b) noexcept {
  const auto side = [&](Corner p) { return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x); };
  Polygon out;
  for (size_t i = 0; i < polygon.count; ++i) {
    const Corner p = polygon.corners[i], q = polygon.corners[(i + 1) % polygon.count];
    const double sp = side(p), sq = side(q);
    if (sp >= 0) out.add(p);
    if ((sp >= 0) == (sq >= 0)) continue;
    const double t = sp / (sp - sq);
    out.add({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
  }
  return out;
}

Box to_box(const Candidate& c) noexcept {
  return {c.x, c.y, c.x + c.width, c.y + c.height};
}

bool is_suppressed(const Candidate& candidate, const Candidates& kept, const Selection& selection) {
  if (selection.rivals == SuppressionScope::None) return false;
  return std::any_of(kept.begin(), kept.end(), [&](const Candidate& better) {
    if (selection.rivals != SuppressionScope::AnyClass &&
        better.class_index != candidate.class_index)
      return false;
    const float common = selection.rivals == SuppressionScope::SameClassRotated
                             ? rotated_overlap(better, candidate)
                             : overlap(to_box(better), to_box(candidate));
    return common > selection.max_overlap;
  });
}

}  // namespace

float rotated_overlap(const Candidate& a, const Candidate& b) noexcept {
  const double areas = double{a.width} * a.height + double{b.width} * b.height;
  if (!(a.width > 0 && a.height > 0 && b.width > 0 && b.height > 0)) return 0;
  // Boxes whose circles do not meet have nothing in common.
  const double reach = (std::hypot(a.width, a.height) + std::hypot(b.width, b.height)) / 2;
  if (std::hypot(double{a.x} - b.x, double{a.y} - b.y) >= reach) return 0;
  Polygon common = to_polygon(a);
  const Polygon other = to_polygon(b);
  for (size_t i = 0; i < other.count; ++i)
    common = clip(common, other.corners[i], other.corners[(i + 1) % other.count]);
  const double area = get_area(common);
  return static_cast<float>(area / (areas - area));
}

Candidates select(Candidates candidates, const Selection& selection) {
  if (!selection.classes.empty())
    std::erase_if(candidates, [&](const Candidate& candidate) {
      return std::find(selection.classes.begin(), selection.classes.end(), candidate.class_index) ==
             selection.classes.end();
    });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  Candidates kept;
  for (const Candidate& candidate : candidates) {
    if (kept.size() == selection.max_objects) break;
    if (!is_suppressed(candidate, kept, selection)) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace weir::results
