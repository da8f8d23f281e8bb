// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/motion.hpp"

#include <algorithm>

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

}  // namespace weir::track
