// The probability of a logit.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>

namespace weir::detection {

// NaN for NaN.
inline float sigmoid(float logit) noexcept {
  return 1 / (1 + std::exp(-logit));
}

}  // namespace weir::detection
