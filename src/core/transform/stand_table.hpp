// Standardises 8-bit elements by a table of the 256 results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

#include "core/transform/stand_scale.hpp"

namespace weir::transform {

// Whether there are enough elements to make building the table worthwhile.
bool has_stand_table(const StandTensor& tensor, const StandTypes& types) noexcept;

// The results equal those of run_stand_strip() with the same scale.
void run_stand_table(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept;

inline constexpr size_t kMaxSteps = 24;  // with more, looking up each element is faster

// A byte table as the changes along its index: `ups` steps of 1, then `downs` steps of -1; step n
// applies from the index below[n] + 1 on. A larger change is several steps.
struct TableSteps {
  uint8_t first = 0;  // the result for 0
  uint8_t below[kMaxSteps] = {};
  size_t ups = 0, downs = 0;
};
// out[i] = first + the steps up to in[i], modulo 256; in and out may be equal. (stand_steps.cpp)
void run_table_steps(const TableSteps& steps, size_t count, bool accelerate, const std::byte* in,
                     std::byte* out) noexcept;

}  // namespace weir::transform
