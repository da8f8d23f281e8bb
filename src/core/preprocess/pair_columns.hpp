// PairColumns: the columns of a resize that makes each pixel of two samples of a row.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <vector>

#include "core/preprocess/axis.hpp"
#include "core/preprocess/row_memory.hpp"

namespace weir::preprocess {

// Samples of 1 to 4 bytes come out as so many lanes of 16 bits.
constexpr size_t pair_lanes(size_t step) noexcept {
  return step == 3 ? 4 : step;
}
// Bytes of a pair when it was taken out of its row.
constexpr size_t pair_bytes(size_t step) noexcept {
  return 2 * pair_lanes(step);
}

// The second sample's part of the pixel, 0 to 1, with a minus sign: 16 bits hold -1 and not 1.
int16_t pair_share(double second) noexcept;

inline constexpr size_t kWindow = 16;  // bytes in which one instruction looks others up
inline constexpr size_t kBlockLanes = kWindow / sizeof(int16_t);
inline constexpr size_t kBlocksPadded = 4;     // what the widest vectors take at once
inline constexpr uint8_t kNothingHere = 0x80;  // in a lookup: the byte becomes 0

struct PairColumns {
  size_t step = 1, count = 0;  // bytes of a sample; pixels
  std::vector<uint32_t> at;    // where a pixel's first sample begins; the second one is behind
  RowMemory<int16_t> shares;   // pair_share() for each lane of each pixel, zeros behind
  // Where neighbours lie near enough: `group` pixels are looked up at once in a window of the row.
  // Each kBlockLanes lanes of the result are a block, of one window or two: part p of block b is
  // read at windows[p][b], and its first and second samples go where lookup[p][0] and [1] have it
  // at 16 * b, as lanes of 16 bits. Blocks are padded to a multiple of kBlocksPadded. Else group
  // is 1.
  size_t group = 1;
  size_t parts() const noexcept { return kBlockLanes / pair_lanes(step) / group; }
  std::vector<uint32_t> windows[2];
  RowMemory<uint8_t> lookup[2][2];
  // Vectors of bytes in a window out of which `wide_lanes` lanes of the result are picked, 0 for
  // none. Window w is read at windows[0][w]; lookup[0][0] has at 64 * w, for each lane, where its
  // first and its second sample are. The farther neighbours lie, the fewer lanes a window makes.
  size_t wide = 0, wide_lanes = 0;

  // Precondition: the axis has at most two weights a target and uses two samples or more. Rows
  // begin with sample low(). Memory is kept.
  void lay(const Axis& axis, size_t step);

 private:
  bool fits(size_t pixels, size_t window, size_t row_bytes) const noexcept;
  void lay_windows(size_t row_bytes);
  void lay_wide_windows(size_t row_bytes);
};

}  // namespace weir::preprocess
