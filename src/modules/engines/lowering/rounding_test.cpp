// Compares rounding in single precision with TensorFlow Lite's integer rounding, sum by sum.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/rounding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace weir::engine {
namespace rounding_test {

// The multiplier as 31 bits and a shift; rounds twice, half up.
int round_twice(int64_t sum, double multiplier, int zero_point) {
  int exponent = 0;
  const auto mantissa =
      static_cast<int64_t>(std::round(std::ldexp(std::frexp(multiplier, &exponent), 31)));
  const int left = std::max(exponent, 0), right = std::max(-exponent, 0);
  const int64_t first = ((sum << left) * mantissa + (int64_t{1} << 30)) >> 31;
  const int64_t half = right > 0 ? int64_t{1} << (right - 1) : 0;
  return static_cast<int>(std::clamp<int64_t>(((first + half) >> right) + zero_point, 0, 255));
}

int round_twice(int64_t sum, const Rounding& rounding, int zero_point) {
  const float real = (static_cast<float>(sum) + rounding.added) / rounding.scale;
  return static_cast<int>(
      std::clamp(std::nearbyint(real) + static_cast<float>(zero_point), 0.0f, 255.0f));
}

int64_t differing_sums(double multiplier, uint8_t zero_point, const Rounding& rounding) {
  const auto reach = static_cast<int64_t>(260 / multiplier);
  int64_t out = 0;
  for (int64_t sum = -reach; sum <= reach; ++sum)
    out += round_twice(sum, multiplier, zero_point) != round_twice(sum, rounding, zero_point);
  return out;
}

TEST(Rounding, EqualsTensorFlowLiteForEverySum) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-10, 0.5);
  int perfect = 0;
  constexpr int kLayers = 50;
  for (int i = 0; i < kLayers; ++i) {
    const double multiplier = std::exp2(exponent(random));
    const auto zero_point = static_cast<uint8_t>(i % 3 == 0 ? 0 : random() % 256);
    const auto rounding = make_rounding(multiplier, zero_point);
    const auto differing = differing_sums(multiplier, zero_point, rounding);
    // A differing step starts exactly one sum early or late.
    EXPECT_LE(differing, rounding.differing) << multiplier;
    EXPECT_LE(rounding.differing, 3) << multiplier;
    perfect += differing == 0;
  }
  EXPECT_GE(perfect, kLayers * 9 / 10);
}

TEST(Rounding, OnceOnlyIsNotEnough) {
  const Rounding once{0, static_cast<float>(1 / 0.3437), 0};
  EXPECT_GT(differing_sums(0.3437, 0, once), 50);
  EXPECT_EQ(differing_sums(0.3437, 0, make_rounding(0.3437, 0)), 0);
}

// A layer of PoseNet: 167331 + 0.8086 is not exact as a float, so a step started one sum late.
TEST(Rounding, WhatIsAddedToALargeBiasIsNotRoundedAway) {
  for (const int64_t bias : {0, 65000, 70000, 167331, 300000, 1000000}) {
    const auto rounding = make_rounding(0.00482966558, 0, bias);
    for (const int64_t with : {bias, -bias}) {
      const double sum = static_cast<double>(with) + static_cast<double>(rounding.added);
      EXPECT_EQ(static_cast<double>(static_cast<float>(sum)), sum) << with;
    }
    EXPECT_EQ(differing_sums(0.00482966558, 0, rounding), 0) << bias;
  }
}

}  // namespace rounding_test
}  // namespace weir::engine
