// BlockSums: the samples of a plane added up in blocks, for all layers of a pyramid that are made
// of whole blocks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/preprocess/row_memory.hpp"
#include "core/preprocess/sum_kernels.hpp"

namespace weir::preprocess {

// Blocks are of 2, 4, 8, 16, 32 or 64 samples of a row: sums of bytes fit into 16 bits, also those
// of most_rows() rows. Where the samples are co-sited (in the middle of the left one of two
// pixels), blocks of pixels begin and end at a quarter of a sample: their samples are counted four
// times, the first one three times and the one behind them once; they are of 16 at most.
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

// Samples of some rows of a plane.
struct SummedSamples {
  size_t plane = 0, low = 0, high = 0;  // from low to below high of each row
  size_t step = 1;                      // lanes of a byte
  bool cosited = false;                 // nothing is counted behind the last one
  bool operator==(const SummedSamples&) const = default;
};

class BlockSums {
 public:
  explicit BlockSums(const SummedSamples& of) noexcept : samples_(of) {}
  const SummedSamples& samples() const noexcept { return samples_; }
  bool wanted() const noexcept { return most_ > 0; }
  // Of other samples, in the same memory. Precondition: not wanted().
  void aim_at(const SummedSamples& of) noexcept { samples_ = of; }

  // `rows`: how many, a power of two up to most_rows(), may be added up too, from multiples of it
  // on; of all wanters the least counts. Where that is 1, up to kRowsTogether are, between two
  // multiples of it (of 2 where somebody wants 2) and two rows of want_begin(): whoever wants less
  // than kRowsTogether says so of each row that no row before may be added to.
  void want(size_t first_row, size_t end_row, size_t block, size_t rows) noexcept;
  // The row is not added to those before it.
  void want_begin(size_t row);
  // Nothing is wanted any more; memory is kept.
  void clear() noexcept;
  // Allocates what make() writes.
  void reserve();
  // The rows in front of `end_row` that were not made yet: row r of the plane begins at memory +
  // r * stride. Precondition: wanted, and reserved since.
  void make(const uint8_t* memory, ptrdiff_t stride, size_t end_row) noexcept;

  // Of `count` rows from `row` on: lane l of the b-th block at b * step + l; the first block is the
  // first one that lies within the samples, blocks being counted from the plane's first sample.
  // Each row of sums is of the rows that were added up. Precondition: such blocks are wanted, and
  // made. Behind the last one are kRowBlock elements more, of any value.
  SummedRows of_rows(size_t row, size_t count, size_t block) const noexcept;
  // How many rows are added up there at most.
  size_t most_rows_of(size_t block) const noexcept {
    const size_t rows = size_t{1} << level(block).rows_log2;
    return rows == 1 ? kRowsTogether : rows;
  }

 private:
  size_t begin(size_t block) const noexcept { return (samples_.low + block - 1) / block; }
  size_t end(size_t block) const noexcept { return samples_.high / block; }
  size_t width(size_t block) const noexcept { return (end(block) - begin(block)) * samples_.step; }

  // Lanes of the blocks before that are no part of the first one.
  size_t skipped(size_t block) const noexcept {
    return block == kLeastBlock ? 0 : (2 * begin(block) - begin(block / 2)) * samples_.step;
  }

  struct Level {
    bool wanted = false;
    unsigned rows_log2 = 0;    // of how many are added up
    RowMemory<uint16_t> sums;  // what is wanted
    RowMemory<uint16_t> row;   // of the row in work
  };
  const Level& level(size_t block) const noexcept;
  Level& level(size_t block) noexcept;
  // Rows of sums before those of `row`.
  size_t sums_before(const Level& level, size_t row) const noexcept {
    if (level.rows_log2 > 0) return (row >> level.rows_log2) - (first_row_ >> level.rows_log2);
    return before_[row - first_row_];
  }
  void lay_runs();

  SummedSamples samples_;
  size_t first_row_ = SIZE_MAX, end_row_ = 0, made_ = 0, most_ = 0;
  std::array<Level, 6> levels_;  // of 2 to 64
  // Whether a run of rows that are added up at once begins with a row, from the plane's first on;
  // the last one is the row behind them all.
  std::vector<uint8_t> begins_;
  std::vector<uint32_t> before_;  // runs before that of a row, from first_row_ on
};

}  // namespace weir::preprocess
