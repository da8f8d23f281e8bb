// Mean and deviation of each of a few channels, and the passes that use them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>

#include "core/transform/stand.hpp"

namespace weir::transform {

inline constexpr size_t kFewChannels = 16;

struct StandScale {
  double mean[kFewChannels] = {};
  double deviation[kFewChannels] = {};  // never 0; not set where nothing is divided
};

// A whole tensor: element i is of channel i % channels.
struct StandTensor {
  size_t count = 0, channels = 1;
};

// What |x - mean| is divided by, for a variance of 0 and NaN too.
double stand_deviation(double variance) noexcept;

// Whether measure_few() can: integers of 8 and 16 bits, float32, and 1 to kFewChannels channels.
bool measures_few(const StandTensor& tensor, ElementType from) noexcept;

// One pass over the memory; the same bits on every CPU. Sums of integers are exact, those of
// float32 are in double. Where their deviation is less than a 64th of the mean, a second pass adds
// up distances from the mean. (stand_sums.cpp)
StandScale measure_few(const StandTensor& tensor, const StandTypes& types, bool accelerate,
                       const std::byte* in) noexcept;

// To float32 in float32: the mean is the sum of two floats, so that an element near to it keeps
// its digits. Errs by at most 2^-22 of the result and 2^-47 of mean / deviation; the same bits on
// every CPU. (stand_float.cpp)
bool scales_in_float(const StandTensor& tensor, const StandTypes& types,
                     const StandScale& scale) noexcept;
void run_stand_float(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept;

}  // namespace weir::transform
