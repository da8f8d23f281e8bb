// Finds the sums at which the output changes in TensorFlow Lite, and matches them in single
// precision.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/rounding.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace weir::engine {
namespace {

constexpr int kSteps = 255;
constexpr float kFinest = 1.0f / 256;
constexpr int kMaxTries = 16;  // tries per direction

using Sums = std::array<double, kSteps>;

// The first sum of value i + 1 - zero_point. The multiplier has 31 bits in TensorFlow Lite.
Sums first_sums(double multiplier, uint8_t zero_point) {
  int exponent = 0;
  const double mantissa = std::round(std::ldexp(std::frexp(multiplier, &exponent), 31));
  const double earlier = exponent < 0 ? 0.5 : 0;  // rounded twice
  Sums out{};
  for (int i = 0; i < kSteps; ++i) {
    const double step = std::ldexp(i - zero_point + 0.5, -exponent);
    out[static_cast<size_t>(i)] = std::ceil(std::ldexp(step - earlier, 31) / mantissa);
  }
  return out;
}

// The finest grain of which every multiple up to `max` is exact as a float.
float grain_for(int64_t max) {
  float grain = kFinest;
  while (static_cast<float>(max) >= std::ldexp(grain, 24)) grain *= 2;
  return grain;
}

// Returns the offset with which each first sum is above the middle between two values and the sum
// before it is not.
float middle_of_added(const Sums& sums, uint8_t zero_point, float scale, float grain) {
  double min = -HUGE_VAL, max = HUGE_VAL;
  for (int i = 0; i < kSteps; ++i) {
    const double border = (i - zero_point + 0.5) * double{scale} - sums[static_cast<size_t>(i)];
    min = std::max(min, border);
    max = std::min(max, border + 1);
  }
  return grain * std::round(static_cast<float>((min + max) / 2) / grain);
}

// Computes as ONNX Runtime's QuantizeLinear does: divides, then rounds half to even.
float value_at(double sum, float added, float scale) {
  return std::nearbyint((static_cast<float>(sum) + added) / scale);
}

int differing_steps(const Sums& sums, uint8_t zero_point, float added, float scale, int enough) {
  int out = 0;
  for (int i = 0; i < kSteps && out < enough; ++i) {
    const double sum = sums[static_cast<size_t>(i)];
    const auto value = static_cast<float>(i - zero_point);
    out += value_at(sum, added, scale) <= value || value_at(sum - 1, added, scale) > value;
  }
  return out;
}

}  // namespace

Rounding make_rounding(double multiplier, uint8_t zero_point, int64_t largest_bias) {
  const float grain = grain_for(largest_bias + 1);
  const auto sums = first_sums(multiplier, zero_point);
  const auto exact = static_cast<float>(1 / multiplier);
  Rounding best{0, exact, kSteps + 1};
  // From the middle outwards: 0, 1, -1, 2, -2, ...
  for (int i = 0; i <= 2 * kMaxTries && best.differing > 0; ++i) {
    float scale = exact;
    for (int step = 0; step < (i + 1) / 2; ++step)
      scale = std::nextafterf(scale, i % 2 == 0 ? 0.0f : HUGE_VALF);
    const float added = middle_of_added(sums, zero_point, scale, grain);
    const int differing = differing_steps(sums, zero_point, added, scale, best.differing);
    if (differing < best.differing) best = {added, scale, differing};
  }
  return best;
}

}  // namespace weir::engine
