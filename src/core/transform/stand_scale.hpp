// StandScale: the mean and deviation of up to kFewChannels channels, and the passes that use them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>

#include "core/transform/stand.hpp"

namespace weir::transform {

inline constexpr size_t kFewChannels = 16;

struct StandScale {
  double mean[kFewChannels] = {};
  double deviation[kFewChannels] = {};  // never 0; unset if nothing is divided
};

// A whole tensor: element i belongs to channel i % channels.
struct StandTensor {
  size_t count = 0, channels = 1;
};

// The divisor of |x - mean|, also for a variance of 0 or NaN.
double stand_deviation(double variance) noexcept;

// Whether measure_few() supports it: integers of 8 and 16 bits or float32, with 1 to kFewChannels
// channels.
bool measures_few(const StandTensor& tensor, ElementType from) noexcept;

// One pass over the memory, with the same bits on every CPU. Integer sums are exact; float32 sums
// are in double. If a deviation is less than 1/64 of the mean, a second pass adds up distances from
// the mean. (stand_sums.cpp)
StandScale measure_few(const StandTensor& tensor, const StandTypes& types, bool accelerate,
                       const std::byte* in) noexcept;

// To float32, computed in float32: the mean is the sum of two floats, so that an element near it
// keeps its digits. The error is at most 2^-22 of the result and 2^-47 of mean / deviation; the
// same bits on every CPU. (stand_float.cpp)
bool scales_in_float(const StandTensor& tensor, const StandTypes& types,
                     const StandScale& scale) noexcept;
void run_stand_float(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept;

}  // namespace weir::transform
