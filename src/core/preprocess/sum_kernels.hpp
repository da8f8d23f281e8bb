// The row loops that add up blocks of samples and blend the sums.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace weir::preprocess {

inline constexpr size_t kRowsTogether = 4;  // rows that are added together at once, at most

// One level of sums: `blocks` blocks, each the sum of two blocks of the level before it, starting
// at element `skipped` of that level's row. The first level sums pairs of samples.
struct SumLevel {
  size_t skipped = 0, blocks = 0;
  uint16_t* row = nullptr;
  // The destination: 2 to the power of rows_log2 rows are added together, starting at multiples of
  // that number; with 0, the rows that are added at once. Null: none.
  uint16_t* sums = nullptr;
  size_t stride = 0;
  unsigned rows_log2 = 0;
};
// `count` rows of a plane, starting with row number `first`. Pairs of samples are added up to the
// first level, its sums to the next and so on. Up to kRowsTogether rows are added at once: from a
// row with begins[row] to the next such row (the row after the last one is one). Rows of sums may
// hold any value in the kRowBlock elements after their blocks. `begun`: an earlier row was already
// added to the first sums.
struct SumRows {
  const uint8_t* memory = nullptr;
  ptrdiff_t stride = 0;
  size_t first = 0, count = 0;
  bool cosited = false;  // counted as in BlockSums; no sample follows the last block
  const uint8_t* begins = nullptr;
  bool begun = false;
};
void add_rows(const SumRows& rows, size_t step, std::span<SumLevel> levels) noexcept;

// The rows of block sums that make one target row: row k begins at rows + k * stride.
struct SummedRows {
  const uint16_t* rows = nullptr;
  size_t stride = 0, count = 0;
};

// The first row has the weight `first`, the last one `last`, all others `between`. Rows with equal
// weights are added before weighting, so the number of rows in each sum does not change the result.
struct SumBlend : SummedRows {
  float first = 0, between = 0, last = 0;
  size_t at_once = 1;  // rows that can be added in 16 bits
};
// Writes lane l of block b, at b * step + l of each row, to out[l][b]. `step`: 1 or 2. Rows and
// `out` extend to a multiple of kRowBlock.
void blend_sums(const SumBlend& blend, size_t step, size_t blocks, float* const* out) noexcept;

}  // namespace weir::preprocess
