// BlockSums: sums of blocks of samples of one plane, computed once for all layers of a pyramid that
// consist of whole blocks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/preprocess/row_memory.hpp"
#include "core/preprocess/sum_kernels.hpp"

namespace weir::preprocess {

// A block is 2, 4, 8, 16, 32 or 64 samples of a row, so that the sum of most_rows() rows of bytes
// fits into 16 bits. With co-sited samples (at the centre of the left one of two pixels), a block
// of pixels begins and ends at a quarter of a sample: its samples count four times, except that the
// first one counts three times and the one after the last counts once. Co-sited blocks hold at most
// 16 samples.
inline constexpr size_t kLeastBlock = 2;
constexpr size_t counted(bool cosited) noexcept {
  return cosited ? 4 : 1;
}
constexpr size_t most_block(bool cosited) noexcept {
  return 64 / counted(cosited);
}
constexpr size_t most_rows(size_t block, bool cosited) noexcept {
  return 256 / counted(cosited) / block;
}
static_assert(most_rows(most_block(false), false) == kRowsTogether &&
              most_rows(most_block(true), true) == kRowsTogether);

// A range of samples in the rows of a plane.
struct SummedSamples {
  size_t plane = 0, low = 0, high = 0;  // [low, high) in each row
  size_t step = 1;                      // bytes from one sample to the next
  bool cosited = false;                 // the last block has no sample after it
  bool operator==(const SummedSamples&) const = default;
};

class BlockSums {
 public:
  explicit BlockSums(const SummedSamples& of) noexcept : samples_(of) {}
  const SummedSamples& samples() const noexcept { return samples_; }
  bool wanted() const noexcept { return most_ > 0; }
  // Selects other samples and keeps the memory. Precondition: not wanted().
  void aim_at(const SummedSamples& of) noexcept { samples_ = of; }

  // `rows`: how many rows may be added together, a power of two up to most_rows(), starting at
  // multiples of it. The smallest value of all callers applies. If that is 1, up to kRowsTogether
  // rows are still added together, but never across a multiple of kRowsTogether (of 2 if a caller
  // passed 2) or a row of want_begin(). A caller that needs fewer than kRowsTogether rows therefore
  // calls want_begin() for each row that must start a new sum.
  void want(size_t first_row, size_t end_row, size_t block, size_t rows) noexcept;
  // Keeps the row from being added to the rows before it.
  void want_begin(size_t row);
  // Forgets all requests; keeps the memory.
  void clear() noexcept;
  // Allocates what make() writes.
  void reserve();
  // Adds up the rows before `end_row` that are not added up yet. Row r of the plane begins at
  // memory + r * stride. Precondition: wanted(), and reserve() was called after the last want().
  void make(const uint8_t* memory, ptrdiff_t stride, size_t end_row) noexcept;

  // The sums of `count` rows from `row` on: lane l of block b is at b * step + l. Block 0 is the
  // first one within the samples; blocks are counted from the plane's first sample. Each row of
  // sums covers the rows that were added together. Precondition: want() asked for such blocks and
  // make() computed them. kRowBlock elements of any value follow the last block.
  SummedRows of_rows(size_t row, size_t count, size_t block) const noexcept;
  // The largest number of rows that are added together.
  size_t most_rows_of(size_t block) const noexcept {
    const size_t rows = size_t{1} << level(block).rows_log2;
    return rows == 1 ? kRowsTogether : rows;
  }

 private:
  size_t begin(size_t block) const noexcept { return (samples_.low + block - 1) / block; }
  size_t end(size_t block) const noexcept { return samples_.high / block; }
  size_t width(size_t block) const noexcept { return (end(block) - begin(block)) * samples_.step; }

  // Lanes of the smaller blocks that precede the first block of this size.
  size_t skipped(size_t block) const noexcept {
    return block == kLeastBlock ? 0 : (2 * begin(block) - begin(block / 2)) * samples_.step;
  }

  struct Level {
    bool wanted = false;
    unsigned rows_log2 = 0;    // log2 of how many rows are added together
    RowMemory<uint16_t> sums;  // the requested sums
    RowMemory<uint16_t> row;   // the sums of the current row
  };
  const Level& level(size_t block) const noexcept;
  Level& level(size_t block) noexcept;
  // The number of rows of sums before the one that contains `row`.
  size_t sums_before(const Level& level, size_t row) const noexcept {
    if (level.rows_log2 > 0) return (row >> level.rows_log2) - (first_row_ >> level.rows_log2);
    return before_[row - first_row_];
  }
  void lay_runs();

  SummedSamples samples_;
  size_t first_row_ = SIZE_MAX, end_row_ = 0, made_ = 0, most_ = 0;
  std::array<Level, 6> levels_;  // block sizes 2 to 64
  // Whether a run of rows that are added together begins at each row of the plane. The last entry
  // stands for the row after them all.
  std::vector<uint8_t> begins_;
  std::vector<uint32_t> before_;  // runs before the run of a row, from first_row_ on
};

}  // namespace weir::preprocess
