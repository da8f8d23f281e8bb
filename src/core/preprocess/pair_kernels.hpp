// The loops over one row where a target pixel is made of two rows and two samples of each.
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/pair_columns.hpp"

namespace weir::preprocess {

// Takes the pairs out of one row, or of two: pair t to byte t * pair_bytes(step). Writes up to
// kWindow bytes behind the last one.
void sample_pairs(const uint8_t* const* rows, size_t row_count, const PairColumns& columns,
                  std::byte* const* out) noexcept;

// Blends the samples of each pair, then the two rows (or takes the only one): out[i] is 128 times
// the value, rounded after each of both. Has an element for each lane; `row_share` is the second
// row's pair_share(). Reads and writes up to padded(count) pixels.
void blend_pairs(const std::byte* const* pairs, size_t row_count, const PairColumns& columns,
                 int16_t row_share, int16_t* out) noexcept;

// Lane l of each pixel to out[l], divided by 128 again. `lanes`: 1, 2 or 4.
void split_lanes(const int16_t* in, size_t lanes, size_t count, float* const* out) noexcept;

}  // namespace weir::preprocess
