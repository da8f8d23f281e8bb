// Code shared by the kernels of both precisions, for one CPU target: splits the pixels of a row
// into blocks that stay in registers, and pooling.
// SPDX-License-Identifier: LGPL-2.1-or-later
#if defined(MTCNN_ROWS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MTCNN_ROWS_INL
#undef MTCNN_ROWS_INL
#else
#define MTCNN_ROWS_INL
#endif
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <utility>

#include "float_kernels.hpp"

HWY_BEFORE_NAMESPACE();
namespace mtcnn::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class Row>
using BlockFunction = void (*)(const Row& row, size_t pixel, size_t channel);

template <class Blocks, size_t kVectors, size_t... kPixels>
constexpr std::array<BlockFunction<typename Blocks::Row>, sizeof...(kPixels)> blocks(
    std::index_sequence<kPixels...>) {
  return {&Blocks::template block<kVectors, kPixels + 1>...};
}

// Blocks::block<kVectors, kPixels> computes kPixels pixels times kVectors vectors of channels, at
// most Blocks::kMaxPixels[kVectors] pixels.
template <class Blocks, size_t kVectors>
void in_blocks(const typename Blocks::Row& row) {
  constexpr size_t kMax = Blocks::kMaxPixels[kVectors];
  static constexpr auto kBlocks = blocks<Blocks, kVectors>(std::make_index_sequence<kMax>());
  const size_t step = kVectors * Blocks::lanes(), end = padded(row.outputs);
  size_t left = (row.pixels + kMax - 1) / kMax;  // splits into blocks of similar size
  for (size_t x = 0; x < row.pixels; --left) {
    const size_t count = (row.pixels - x + left - 1) / left;
    for (size_t channel = 0; channel < end; channel += step) kBlocks[count - 1](row, x, channel);
    x += count;
  }
}

template <class Number>
void Pool(const PoolRow<Number>& row) {
  const hn::CappedTag<Number, kGroup> d;
  const size_t lanes = hn::Lanes(d), channels = row.channels;
  // In ascending order: the excess lanes of a vector overlap the next pixel.
  for (size_t x = 0; x < row.out_pixels; ++x) {
    const size_t first = 2 * x * row.in_step;
    const size_t columns = std::min(row.width, row.in_pixels - 2 * x);
    for (size_t c = 0; c < channels; c += lanes) {
      auto max = hn::LoadU(d, row.rows[0] + first + c);
      for (size_t r = 0; r < row.height; ++r)
        for (size_t column = 0; column < columns; ++column)
          max = hn::Max(max, hn::LoadU(d, row.rows[r] + first + column * row.in_step + c));
      hn::StoreU(max, d, row.out + x * row.out_step + c);
    }
  }
}

}  // namespace mtcnn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
