// Reproduces in floating point how TensorFlow Lite rounds sums of uint8 products.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

namespace weir::engine {

// TensorFlow Lite rounds twice, half up: the sum times a multiplier from 0.5 to 1, and that value
// shifted right. It therefore reaches the next step earlier than round(sum * multiplier), by 0.5 to
// 1 of the sum. round((sum + added) / scale) gives the same steps.
struct Rounding {
  float added = 0, scale = 1;
  int differing = 0;  // how many of the output's 255 steps start at another sum
};

// `multiplier` converts sums to output values with this zero point. Tries single-precision scales
// near 1 / multiplier, each with the middle of the possible offsets. The offset is a multiple of
// 1/256, or of more for a bias above 65536: it is added to the bias, and their sum must be exact as
// a float.
Rounding make_rounding(double multiplier, uint8_t zero_point, int64_t largest_bias = 0);

}  // namespace weir::engine
