// Bootstrap: how far a score would vary with other pictures of the same kind. Pictures are drawn
// with replacement, as many as there are, and the score is computed again, many times.
//
// Two pipelines are compared with the same draws (paired), so that a picture that is hard for both
// does not blur their difference.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "core/evaluate/scores.hpp"

namespace weir::evaluate {

struct Interval {
  double low = kUndefined, high = kUndefined;  // undefined when no draw has the score
};

// Numbers of a draw in which unit i counts times[i] times. Always the same count of numbers.
using Measure = std::function<std::vector<double>(Times times)>;

// The central 95 % of each number over `draws` draws of `units` units. The same seed gives the same
// draws on every machine. Precondition: units > 0, draws > 0.
std::vector<Interval> bootstrap(size_t units, size_t draws, uint64_t seed, const Measure& measure);

}  // namespace weir::evaluate
