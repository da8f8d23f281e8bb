// The row loops that make each target pixel from two rows and two samples of each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/pair_columns.hpp"
#include "core/preprocess/source_rows.hpp"

namespace weir::preprocess {

// Bytes for the pairs of one row when they are read one by one.
constexpr size_t pairs_memory(size_t padded_pixels, size_t step) noexcept {
  return padded_pixels * pair_bytes(step);
}

// Blends the samples of each pair, then the two rows (or uses the only row). out[i] is 128 times
// the value for each lane of each pixel, rounded after each of the two steps. `row_share` is the
// pair_share() of the second row. `pairs` holds pairs_memory() bytes for each row. Writes up to
// padded(count) pixels.
void blend_pairs(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                 std::byte* const* pairs, int16_t* out) noexcept;

}  // namespace weir::preprocess
