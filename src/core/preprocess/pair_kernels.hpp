// The loops over one row where a target pixel is made of two rows and two samples of each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/pair_columns.hpp"
#include "core/preprocess/source_rows.hpp"

namespace weir::preprocess {

// Memory for the pairs of one row where they are taken one by one.
constexpr size_t pairs_memory(size_t padded_pixels, size_t step) noexcept {
  return padded_pixels * pair_bytes(step);
}

// Blends the samples of each pair, then the two rows (or takes the only one): out[i] is 128 times
// the value, rounded after each of both, for each lane of each pixel. `row_share` is the second
// row's pair_share(). `pairs`: pairs_memory() for each row. Writes up to padded(count) pixels.
void blend_pairs(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                 std::byte* const* pairs, int16_t* out) noexcept;

}  // namespace weir::preprocess
