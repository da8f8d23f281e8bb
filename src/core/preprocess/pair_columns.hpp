// PairColumns: the column tables of a resize that makes each pixel from two samples of a row.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <vector>

#include "core/preprocess/axis.hpp"
#include "core/preprocess/row_memory.hpp"

namespace weir::preprocess {

// Lanes of 16 bits that a sample of 1 to 4 bytes becomes.
constexpr size_t pair_lanes(size_t step) noexcept {
  return step == 3 ? 4 : step;
}
// Bytes of a pair after it is read from its row.
constexpr size_t pair_bytes(size_t step) noexcept {
  return 2 * pair_lanes(step);
}

// The negated weight, 0 to 1, of the second sample: 16 bits hold -1 but not 1.
int16_t pair_share(double second) noexcept;

inline constexpr size_t kWindow = 16;  // bytes that one table lookup instruction reads
inline constexpr size_t kBlockLanes = kWindow / sizeof(int16_t);
inline constexpr size_t kBlocksPadded = 4;     // blocks in the widest vector
inline constexpr uint8_t kNothingHere = 0x80;  // lookup index: the byte becomes 0

struct PairColumns {
  size_t step = 1, count = 0;  // bytes of a sample; number of pixels
  std::vector<uint32_t> at;    // byte offset of each pixel's first sample; the second one follows
  RowMemory<int16_t> shares;   // pair_share() for each lane of each pixel, then zeros
  // If the samples of neighbouring pixels are close enough, `group` pixels are looked up together
  // in one window of the row; otherwise group is 1. A block is kBlockLanes lanes of the result and
  // uses one or two windows: part p of block b is read at windows[p][b], and lookup[p][0] and [1],
  // at 16 * b, place its first and second samples as lanes of 16 bits. Blocks are padded to a
  // multiple of kBlocksPadded.
  size_t group = 1;
  size_t parts() const noexcept { return kBlockLanes / pair_lanes(step) / group; }
  std::vector<uint32_t> windows[2];
  RowMemory<uint8_t> lookup[2][2];
  // The number of vectors in a window from which `wide_lanes` lanes of the result are picked; 0 if
  // unused. Window w is read at windows[0][w]. At 64 * w, lookup[0][0] holds for each lane the
  // places of its first and second sample. The farther apart the samples of neighbouring pixels
  // are, the fewer lanes one window provides.
  size_t wide = 0, wide_lanes = 0;

  // Precondition: the axis has at most two weights per target and uses at least two samples. Rows
  // begin with sample low(). Keeps the allocated memory.
  void lay(const Axis& axis, size_t step);

 private:
  bool fits(size_t pixels, size_t window, size_t row_bytes) const noexcept;
  void lay_windows(size_t row_bytes);
  void lay_wide_windows(size_t row_bytes);
};

}  // namespace weir::preprocess
