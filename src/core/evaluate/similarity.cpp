// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/similarity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weir::evaluate {
namespace {

double common_area(const Rectangle& a, const Rectangle& b) noexcept {
  const double width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  return width > 0 && height > 0 ? width * height : 0;
}

// How far `at` is outside of begin to end.
double distance_outside(double at, double begin, double end) noexcept {
  return std::max(0.0, begin - at) + std::max(0.0, at - end);
}

}  // namespace

double overlap(const Rectangle& a, const Rectangle& b) noexcept {
  const double common = common_area(a, b), all = a.area() + b.area() - common;
  return all > 0 ? common / all : 0;
}

double part_in_crowd(const Rectangle& found, const Rectangle& crowd) noexcept {
  return found.area() > 0 ? common_area(found, crowd) / found.area() : 0;
}

std::vector<double> key_point_deviations(size_t points) {
  // Nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles.
  static constexpr double kPerson[] = {.026, .025, .025, .035, .035, .079, .079, .072, .072,
                                       .062, .062, .107, .107, .087, .087, .089, .089};
  if (points == std::size(kPerson)) return {std::begin(kPerson), std::end(kPerson)};
  return std::vector<double>(points, 1.0 / static_cast<double>(std::max<size_t>(points, 1)));
}

double key_point_similarity(const TruthObject& truth, const FoundObject& found,
                            std::span<const double> deviations) noexcept {
  const size_t points = std::min({truth.points.size(), found.points.size(), deviations.size()});
  const auto is_labelled = [](const LabelledPoint& point) { return point.is_labelled; };
  const bool any = std::any_of(truth.points.begin(), truth.points.end(), is_labelled);
  const Rectangle& box = truth.box;
  double sum = 0;
  size_t counted = 0;
  for (size_t i = 0; i < deviations.size() && i < truth.points.size(); ++i) {
    if (any && !truth.points[i].is_labelled) continue;
    ++counted;
    if (i >= points || !found.points[i].is_labelled) continue;  // not found: infinitely far
    double dx = found.points[i].x - truth.points[i].x, dy = found.points[i].y - truth.points[i].y;
    if (!any) {
      dx = distance_outside(found.points[i].x, box.x - box.width, box.x + 2 * box.width);
      dy = distance_outside(found.points[i].y, box.y - box.height, box.y + 2 * box.height);
    }
    const double variance = 4 * deviations[i] * deviations[i];
    const double size = truth.area + std::numeric_limits<double>::epsilon();
    sum += std::exp(-(dx * dx + dy * dy) / (2 * variance * size));
  }
  return counted > 0 ? sum / static_cast<double>(counted) : 0;
}

}  // namespace weir::evaluate
