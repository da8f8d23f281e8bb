// Standardises elements of 8 bits by a table of the 256 results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

#include "core/transform/stand_scale.hpp"

namespace weir::transform {

// Whether there are enough elements that the table is worth its making.
bool has_stand_table(const StandTensor& tensor, const StandTypes& types) noexcept;

// The results are those of run_stand_strip() with the same scale.
void run_stand_table(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept;

inline constexpr size_t kMostSteps = 24;  // more take longer than looking up each element

// A table of bytes as what it adds while its index grows: `ups` steps of 1 and then `downs` of -1,
// each from the index below[n] + 1 on. A change by more is several steps.
struct TableSteps {
  uint8_t first = 0;  // the result of 0
  uint8_t below[kMostSteps] = {};
  size_t ups = 0, downs = 0;
};
// out[i] = first + the steps up to in[i], modulo 256; in and out may be the same. (stand_steps.cpp)
void run_table_steps(const TableSteps& steps, size_t count, bool accelerate, const std::byte* in,
                     std::byte* out) noexcept;

}  // namespace weir::transform
