// Blends pairs from windows of one to four 64-byte vectors on CPUs that permute bytes of whole
// vectors (AVX-512 with VBMI).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/preprocess/pair_columns.hpp"
#include "core/preprocess/source_rows.hpp"

namespace weir::preprocess {

// 16-bit lanes that one window provides: a whole vector, a half or a quarter.
inline constexpr size_t kWideLanes = 32, kFewestWideLanes = 8, kWideBytes = 64;
inline constexpr size_t kWideVectors = 4;  // as many as a byte can address

// Whether this CPU has these instructions and no test has disabled them.
bool has_wide_windows() noexcept;

// blend_pairs() for columns with `wide` above 0.
void blend_wide_windows(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                        int16_t* out) noexcept;

}  // namespace weir::preprocess
