// Scores: what a metric gives for a set of units, which are pictures or sequences.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace weir::evaluate {

// The value of a score that is not defined, such as the precision of a class without objects.
inline constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

struct Score {
  std::string name;
  double value = kUndefined;
};
using Scores = std::vector<Score>;

// How often each unit counts. Empty: each counts once. A bootstrap draws these numbers.
using Times = std::span<const uint32_t>;
inline uint32_t count_times(Times times, size_t unit) noexcept {
  return times.empty() ? 1 : times[unit];
}

// `part` / `all`, undefined when `all` is 0.
inline double ratio(double part, double all) noexcept {
  return all > 0 ? part / all : kUndefined;
}

}  // namespace weir::evaluate
