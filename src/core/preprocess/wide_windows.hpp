// Pairs of samples out of windows of one to four vectors of 64 bytes, where the CPU picks bytes
// from whole vectors (AVX-512 with VBMI).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/preprocess/pair_columns.hpp"
#include "core/preprocess/source_rows.hpp"

namespace weir::preprocess {

// Lanes of 16 bits that one window makes: all of a vector, a half or a quarter.
inline constexpr size_t kWideLanes = 32, kFewestWideLanes = 8, kWideBytes = 64;
inline constexpr size_t kWideVectors = 4;  // a byte tells a place in so many

// Whether this CPU has it, and a test did not say that it shall be as if it had not.
bool has_wide_windows() noexcept;

// blend_pairs() of columns that are `wide`.
void blend_wide_windows(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                        int16_t* out) noexcept;

}  // namespace weir::preprocess
