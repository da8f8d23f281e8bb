// Counts, for the offset of each pair of a predicted box and a box, how many predicted boxes have a
// pair with nearly the same offset.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/common_motion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace weir::track {
namespace {

constexpr size_t kMostBoxes = 32;  // that are looked at, so that crowds cost no more
constexpr size_t kLeastAgreeing = 3;
constexpr float kReach = 1.0f;      // of the box's height: the farthest offset
constexpr float kTolerance = 0.1f;  // of the box's height: offsets that are nearly the same
constexpr float kSizeRatio = 1.25f;
constexpr float kSignificant = 3;  // times the deviation of a mean

struct Offset {
  size_t box;
  float x, y, tolerance;
};

bool is_like(float a, float b) {
  return a <= b * kSizeRatio && b <= a * kSizeRatio;
}

std::vector<Offset> offsets_of(std::span<const Box> predicted, std::span<const Box> boxes) {
  std::vector<Offset> out;
  for (size_t i = 0; i < predicted.size(); ++i) {
    const Box& p = predicted[i];
    for (const Box& b : boxes) {
      const float x = (b.x1 + b.x2 - p.x1 - p.x2) / 2, y = (b.y1 + b.y2 - p.y1 - p.y2) / 2;
      const float reach = kReach * p.height();
      if (std::abs(x) > reach || std::abs(y) > reach) continue;
      if (is_like(b.width(), p.width()) && is_like(b.height(), p.height()))
        out.push_back({i, x, y, kTolerance * p.height()});
    }
  }
  return out;
}

// The offset of each predicted box that is nearest to `centre`, of those within the tolerance.
// `offsets` are in the order of their boxes.
std::vector<Offset> agreeing(std::span<const Offset> offsets, Shift centre) {
  std::vector<Offset> out;
  const auto distance = [&](const Offset& o) {
    return std::max(std::abs(o.x - centre.x), std::abs(o.y - centre.y));
  };
  for (const Offset& o : offsets) {
    if (distance(o) > o.tolerance) continue;
    if (out.empty() || out.back().box != o.box)
      out.push_back(o);
    else if (distance(o) < distance(out.back()))
      out.back() = o;
  }
  return out;
}

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The median, or 0 where the noise of the boxes alone may be the cause.
float significant_median(std::vector<float> values) {
  const float centre = median(values), count = static_cast<float>(values.size());
  for (float& v : values) v = std::abs(v - centre);
  const float deviation = 1.4826f * median(std::move(values));  // of a normal distribution
  return std::abs(centre) > kSignificant * deviation / std::sqrt(count) ? centre : 0;
}

}  // namespace

Shift common_motion(std::span<const Box> predicted, std::span<const Box> boxes) {
  predicted = predicted.first(std::min(predicted.size(), kMostBoxes));
  const auto offsets = offsets_of(predicted, boxes);
  std::vector<Offset> best = agreeing(offsets, {});  // no motion, unless another one has more
  for (const Offset& o : offsets) {
    auto some = agreeing(offsets, {o.x, o.y});
    if (some.size() > best.size()) best = std::move(some);
  }
  if (best.size() < kLeastAgreeing || 2 * best.size() < predicted.size()) return {};
  std::vector<float> x, y;
  for (const Offset& o : best) x.push_back(o.x), y.push_back(o.y);
  return {significant_median(std::move(x)), significant_median(std::move(y))};
}

}  // namespace weir::track
