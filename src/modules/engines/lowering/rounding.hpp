// How TensorFlow Lite rounds sums of products of uint8, in terms of real numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

namespace weir::engine {

// TensorFlow Lite rounds twice: the sum times a multiplier from 0.5 to 1 to a whole number, and
// that, shifted to the right, once more, halves upwards. So it comes to the next step sooner than
// round(sum * multiplier), by 0.5 to 1 of the sum. round((sum + added) / scale) is the same.
struct Rounding {
  float added = 0, scale = 1;
  int differing = 0;  // of the 255 steps of the output, those that begin at another sum
};

// `multiplier`: from sums to values of the output, whose zero point is given. In single precision
// some scales about 1 / multiplier are tried, each with the middle of what may be added. That is a
// multiple of 1/256, or of more where a bias is larger than 65536: what is added joins the bias,
// and their sum must be a float without error.
Rounding rounding_of(double multiplier, uint8_t zero_point, int64_t largest_bias = 0);

}  // namespace weir::engine
