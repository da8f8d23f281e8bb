// Keeps the key points of candidates until it is known which are kept.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/points_head.hpp"

#include <algorithm>
#include <cmath>

#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

Box box_around(std::span<const results::KeyPoint> points, float min) noexcept {
  Box box{INFINITY, INFINITY, -INFINITY, -INFINITY};
  for (const auto& point : points) {
    if (point.score < min) continue;
    box.x1 = std::min(box.x1, point.x), box.x2 = std::max(box.x2, point.x);
    box.y1 = std::min(box.y1, point.y), box.y2 = std::max(box.y2, point.y);
  }
  return box;
}

}  // namespace

results::KeyPoint key_point(float x, float y, float score) noexcept {
  if (!std::isfinite(x) || !std::isfinite(y)) return {};
  return {x, y, to_probability(score)};
}

void PointsHead::begin() noexcept {
  found_.clear();
  points_.clear();
}

void PointsHead::add(std::span<const results::KeyPoint> points, float min, float score,
                     int32_t class_index) {
  const bool any = std::any_of(points.begin(), points.end(),
                               [&](const auto& point) { return point.score >= min; });
  const size_t before = found_.size();
  add(points, box_around(points, any ? min : 0), score);
  if (found_.size() > before) found_.back().class_index = class_index;
}

void PointsHead::add(std::span<const results::KeyPoint> points, const Box& box, float score) {
  const detection::Candidate candidate{.x = box.x1,
                                       .y = box.y1,
                                       .width = box.width(),
                                       .height = box.height(),
                                       .score = score,
                                       .class_index = 0,
                                       .row = static_cast<uint32_t>(found_.size())};
  if (!candidate.is_finite()) return;
  found_.push_back(candidate);
  points_.insert(points_.end(), points.begin(), points.end());
}

void PointsHead::complete(OutputValues&, std::span<const detection::Candidate> kept, Size,
                          results::FrameResults* results) {
  for (const auto& candidate : kept) {
    const auto first = points_.begin() + static_cast<ptrdiff_t>(candidate.row * points_per_object_);
    results->points.insert(results->points.end(), first,
                           first + static_cast<ptrdiff_t>(points_per_object_));
  }
}

}  // namespace weir::heads
