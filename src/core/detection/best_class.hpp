// Finds the best class of a row of scores.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace weir::detection {

// The greatest score; -infinity if there is none. NaN is less than every number.
inline float best_score(std::span<const float> scores) noexcept {
  constexpr size_t kLanes = 8;  // independent maxima, which the compiler turns into vector code
  std::array<float, kLanes> best;
  best.fill(-std::numeric_limits<float>::infinity());
  const size_t whole = scores.size() / kLanes * kLanes;
  for (size_t i = 0; i < whole; i += kLanes)
    for (size_t lane = 0; lane < kLanes; ++lane)
      best[lane] = scores[i + lane] > best[lane] ? scores[i + lane] : best[lane];
  for (size_t i = whole; i < scores.size(); ++i)
    best[0] = scores[i] > best[0] ? scores[i] : best[0];
  for (size_t lane = 1; lane < kLanes; ++lane)
    best[0] = best[lane] > best[0] ? best[lane] : best[0];
  return best[0];
}

// The first class with this score; 0 if there is none.
inline int32_t class_with(std::span<const float> scores, float score) noexcept {
  for (size_t i = 0; i < scores.size(); ++i)
    if (scores[i] == score) return static_cast<int32_t>(i);
  return 0;
}

}  // namespace weir::detection
