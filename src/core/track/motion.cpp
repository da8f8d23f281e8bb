// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/motion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace weir::track {
namespace {

constexpr double kValueNoise = 1.0 / 20, kSpeedNoise = 1.0 / 160;  // of the box's height

std::array<double, 4> measured(const Box& b) {
  return {(double{b.x1} + b.x2) / 2, (double{b.y1} + b.y2) / 2, double{b.x2} - b.x1,
          double{b.y2} - b.y1};
}
double square(double x) {
  return x * x;
}

// Boxes that are looked at, and offsets of each, so that crowds cost no more.
constexpr size_t kMaxBoxes = 32, kMaxOffsets = 64;
constexpr size_t kMinAgreeing = 3;
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

// The offsets of each predicted box to those of nearly its size, the shortest ones.
std::vector<Offset> compute_offsets(std::span<const Box> predicted, std::span<const Box> boxes) {
  std::vector<Offset> out;
  for (size_t i = 0; i < predicted.size(); ++i) {
    const Box& p = predicted[i];
    const size_t first = out.size();
    for (const Box& b : boxes) {
      const float x = (b.x1 + b.x2 - p.x1 - p.x2) / 2, y = (b.y1 + b.y2 - p.y1 - p.y2) / 2;
      const float reach = kReach * p.height();
      if (std::abs(x) > reach || std::abs(y) > reach) continue;
      if (is_like(b.width(), p.width()) && is_like(b.height(), p.height()))
        out.push_back({i, x, y, kTolerance * p.height()});
    }
    if (out.size() - first <= kMaxOffsets) continue;
    const auto begin = out.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(kMaxOffsets);
    std::nth_element(begin, end, out.end(), [](const Offset& a, const Offset& b) {
      return std::max(std::abs(a.x), std::abs(a.y)) < std::max(std::abs(b.x), std::abs(b.y));
    });
    out.erase(end, out.end());
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

BoxMotion::BoxMotion(const Box& box) noexcept {
  const auto z = measured(box);
  for (size_t i = 0; i < 4; ++i) axes_[i].value = z[i];
  for (auto& a : axes_) {
    a.vv = square(2 * kValueNoise * scale());
    a.ss = square(10 * kSpeedNoise * scale());
  }
}

double BoxMotion::scale() const noexcept {
  return std::max(axes_[3].value, 1e-3);
}

void BoxMotion::predict(double steps, bool keep_size) noexcept {
  const double value = square(kValueNoise * scale()) * steps;
  const double speed = square(kSpeedNoise * scale()) * steps;
  if (keep_size) axes_[2].speed = axes_[3].speed = 0;
  for (auto& a : axes_) {
    a.value += a.speed * steps;
    a.vv += 2 * a.vs * steps + a.ss * steps * steps + value;
    a.vs += a.ss * steps;
    a.ss += speed;
  }
  for (size_t i = 2; i < 4; ++i) axes_[i].value = std::max(axes_[i].value, 1e-3);
}

void BoxMotion::shift(float x, float y) noexcept {
  axes_[0].value += x;
  axes_[1].value += y;
}

void BoxMotion::correct(const Box& box) noexcept {
  const auto z = measured(box);
  const double noise = square(kValueNoise * scale());
  for (size_t i = 0; i < 4; ++i) {
    auto& a = axes_[i];
    const double sum = a.vv + noise, gain = a.vv / sum, speed_gain = a.vs / sum;
    const double error = z[i] - a.value;
    a.value += gain * error;
    a.speed += speed_gain * error;
    a.ss -= speed_gain * a.vs;
    a.vs *= 1 - gain;
    a.vv *= 1 - gain;
  }
}

double BoxMotion::distance(const Box& box) const noexcept {
  const auto z = measured(box);
  const double noise = square(kValueNoise * scale());
  double sum = 0;
  for (size_t i = 0; i < 4; ++i) sum += square(z[i] - axes_[i].value) / (axes_[i].vv + noise);
  return sum;
}

Box BoxMotion::box() const noexcept {
  const double w = axes_[2].value / 2, h = axes_[3].value / 2;
  return {static_cast<float>(axes_[0].value - w), static_cast<float>(axes_[1].value - h),
          static_cast<float>(axes_[0].value + w), static_cast<float>(axes_[1].value + h)};
}

Shift common_motion(std::span<const Box> predicted, std::span<const Box> boxes) {
  predicted = predicted.first(std::min(predicted.size(), kMaxBoxes));
  const auto offsets = compute_offsets(predicted, boxes);
  std::vector<Offset> best = agreeing(offsets, {});  // no motion, unless another one has more
  for (const Offset& o : offsets) {
    auto some = agreeing(offsets, {o.x, o.y});
    if (some.size() > best.size()) best = std::move(some);
  }
  if (best.size() < kMinAgreeing || 2 * best.size() < predicted.size()) return {};
  std::vector<float> x, y;
  for (const Offset& o : best) x.push_back(o.x), y.push_back(o.y);
  return {significant_median(std::move(x)), significant_median(std::move(y))};
}

}  // namespace weir::track
