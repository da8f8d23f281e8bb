// Selects the rows that are added together and lays out their sums.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/block_sums.hpp"

#include <algorithm>
#include <bit>

#include "core/preprocess/row_kernels.hpp"

namespace weir::preprocess {
namespace {

size_t level_of(size_t block) noexcept {
  return static_cast<size_t>(std::countr_zero(block / kLeastBlock));
}

}  // namespace

const BlockSums::Level& BlockSums::level(size_t block) const noexcept {
  return levels_[level_of(block)];
}
BlockSums::Level& BlockSums::level(size_t block) noexcept {
  return levels_[level_of(block)];
}

void BlockSums::want(size_t first_row, size_t end_row, size_t block, size_t rows) noexcept {
  first_row_ = std::min(first_row_, first_row);
  end_row_ = std::max(end_row_, end_row);
  most_ = std::max(most_, block);
  made_ = first_row_;
  Level& l = level(block);
  const auto log2 = static_cast<unsigned>(std::countr_zero(rows));
  l.rows_log2 = l.wanted ? std::min(l.rows_log2, log2) : log2;
  l.wanted = true;
}

void BlockSums::want_begin(size_t row) {
  if (begins_.size() <= row) begins_.resize(row + 1);
  begins_[row] = 1;
}

void BlockSums::clear() noexcept {
  first_row_ = SIZE_MAX, end_row_ = 0, most_ = 0;
  begins_.clear();
  for (Level& l : levels_) l.wanted = false;
}

void BlockSums::lay_runs() {
  const bool in_pairs = std::any_of(levels_.begin(), levels_.end(),
                                    [](const Level& l) { return l.wanted && l.rows_log2 == 1; });
  const size_t step = in_pairs ? 2 : kRowsTogether;
  begins_.resize(end_row_ + 1);
  begins_[first_row_] = begins_[end_row_] = 1;
  for (size_t row = first_row_ / step * step + step; row < end_row_; row += step) begins_[row] = 1;
  before_.resize(end_row_ - first_row_);
  for (size_t row = first_row_ + 1; row < end_row_; ++row)
    before_[row - first_row_] = before_[row - first_row_ - 1] + begins_[row];
}

void BlockSums::reserve() {
  if (most_ == 0) return;
  lay_runs();
  const auto at_least = [](RowMemory<uint16_t>* memory, size_t size) {
    if (memory->size() < size) memory->resize(size);
  };
  for (size_t block = kLeastBlock; block <= most_; block *= 2) {
    Level& l = level(block);
    at_least(&l.row, width(block) + 2 * kRowBlock);
    if (l.wanted)
      at_least(&l.sums, width(block) * (sums_before(l, end_row_ - 1) + 1) + 2 * kRowBlock);
  }
}

// Computes all levels of a row while the row is in the L1 cache; the sums over several rows are
// much smaller than the bytes. Writes past the end of a row of sums reach into the next one, which
// is written later.
void BlockSums::make(const uint8_t* memory, ptrdiff_t stride, size_t end_row) noexcept {
  if (made_ >= end_row) return;
  while (!begins_[end_row]) ++end_row;
  std::array<SumLevel, std::tuple_size_v<decltype(levels_)>> levels;
  size_t count = 0;
  for (size_t block = kLeastBlock; block <= most_; block *= 2) {
    Level& l = level(block);
    uint16_t* const sums =
        l.wanted ? l.sums.data() + sums_before(l, made_) * width(block) : nullptr;
    levels[count++] = {skipped(block), end(block) - begin(block), l.row.data(), sums, width(block),
                       l.rows_log2};
  }
  const SumRows rows{memory + kLeastBlock * begin(kLeastBlock) * samples_.step,
                     stride,
                     made_,
                     end_row - made_,
                     samples_.cosited,
                     begins_.data(),
                     made_ > first_row_};
  add_rows(rows, samples_.step, {levels.data(), count});
  made_ = end_row;
}

SummedRows BlockSums::of_rows(size_t row, size_t count, size_t block) const noexcept {
  const Level& l = level(block);
  const size_t first = sums_before(l, row);
  return {l.sums.data() + first * width(block), width(block),
          sums_before(l, row + count - 1) - first + 1};
}

}  // namespace weir::preprocess
