// The loops over rows of sums of blocks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace weir::preprocess {

inline constexpr size_t kRowsTogether = 4;  // that are added up at once, at most

// Sums in work: of `blocks` blocks, each of two of the level before, from element `skipped` of its
// row on. Those of the first level are of pairs of samples.
struct SumLevel {
  size_t skipped = 0, blocks = 0;
  uint16_t* row = nullptr;
  // Where the rows go: as many as 2 to the power of rows_log2 are added up, beginning with the
  // multiples of it; of 0 those that are added at once. Null: nowhere.
  uint16_t* sums = nullptr;
  size_t stride = 0;
  unsigned rows_log2 = 0;
};
// Rows of a plane, `count` of them, the first of which is number `first`: pairs of samples are
// added up to the first level, these to the next and so on, up to kRowsTogether rows at once: from
// one with begins[row] to the next, which the row behind them all is. Rows of sums go on, and may
// be of any value, up to kRowBlock elements behind their blocks. begun: whether a row before was
// added to the first sums.
struct SumRows {
  const uint8_t* memory = nullptr;
  ptrdiff_t stride = 0;
  size_t first = 0, count = 0;
  bool cosited = false;  // BlockSums tells how these are counted; none is behind the last block
  const uint8_t* begins = nullptr;
  bool begun = false;
};
void add_rows(const SumRows& rows, size_t step, std::span<SumLevel> levels) noexcept;

// Rows of sums of blocks of which a row is made: row k begins at rows + k * stride.
struct SummedRows {
  const uint16_t* rows = nullptr;
  size_t stride = 0, count = 0;
};

// The first row has the weight `first`, the last one `last`, those between them `between`. Rows of
// one weight are added up before they get it: how many rows of bytes a row is the sum of changes
// nothing.
struct SumBlend : SummedRows {
  float first = 0, between = 0, last = 0;
  size_t at_once = 1;  // so many rows can be added up in 16 bits
};
// Lane l of block b, b * step + l of each row, to out[l][b]. `step`: 1 or 2. Rows and `out` go on
// to a multiple of kRowBlock.
void blend_sums(const SumBlend& blend, size_t step, size_t blocks, float* const* out) noexcept;

// out[i] = 2 to the power of `shift` times the sum of element i of all rows, which fits into 16
// bits. Rows and `out` go on to a multiple of kRowBlock.
void add_sums(const SummedRows& in, size_t elements, unsigned shift, int16_t* out) noexcept;

}  // namespace weir::preprocess
