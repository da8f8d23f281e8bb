// Blends pairs of samples; compiled once per CPU target. 128 times a byte, and differences of such
// values, fit into 16 bits; the result is rounded to 1/128 of a step of 255.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/pair_kernels.hpp"

#include <bit>
#include <cstring>

#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/wide_windows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/pair_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // no vector for byte lookups

int16_t share_of(int difference, int16_t share) {
  return static_cast<int16_t>((difference * share + (1 << 14)) >> 15);
}

int blended(int first, int second, int16_t share) {
  return 128 * first + share_of(128 * (first - second), share);
}

// first(row, pixel) returns the pixel's first sample; the second one is `step` bytes later.
template <class First>
void blend(const PairColumns& columns, size_t row_count, int16_t row_share, int16_t* out,
           First&& first) {
  const size_t lanes = pair_lanes(columns.step);
  for (size_t i = 0; i < columns.count * lanes; ++i) {
    if (i % lanes >= columns.step) continue;
    const auto at = [&](size_t row) {
      const uint8_t* sample = first(row, i / lanes) + i % lanes;
      return blended(sample[0], sample[columns.step], columns.shares[i]);
    };
    const int value = at(0);
    out[i] =
        static_cast<int16_t>(row_count == 2 ? value + share_of(value - at(1), row_share) : value);
  }
}

void BlendPairs(const std::byte* const* pairs, size_t row_count, const PairColumns& columns,
                int16_t row_share, int16_t* out) {
  const size_t bytes = pair_bytes(columns.step);
  blend(columns, row_count, row_share, out, [&](size_t row, size_t pixel) {
    return reinterpret_cast<const uint8_t*>(pairs[row]) + pixel * bytes;
  });
}

void BlendWindows(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                  int16_t* out) {
  blend(columns, from.count, row_share, out,
        [&](size_t row, size_t pixel) { return from.rows[row] + columns.at[pixel]; });
}

#else

using S = hn::ScalableTag<int16_t>;
using B = hn::Repartition<uint8_t, S>;
static_assert(hn::MaxLanes(S()) <= kRowBlock);

// Moves the bytes of 16 bytes of pairs to lanes of 16 bits: first samples, then second samples.
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define WEIR_LANE(a) a, kNothingHere
#else
#define WEIR_LANE(a) kNothingHere, a
#endif
#define WEIR_LANES(a, b, c, d, e, f, g, h)                                              \
  {                                                                                     \
    WEIR_LANE(a), WEIR_LANE(b), WEIR_LANE(c), WEIR_LANE(d), WEIR_LANE(e), WEIR_LANE(f), \
        WEIR_LANE(g), WEIR_LANE(h)                                                      \
  }
alignas(16) constexpr uint8_t kLanes[4][2][16] = {
    {WEIR_LANES(0, 2, 4, 6, 8, 10, 12, 14), WEIR_LANES(1, 3, 5, 7, 9, 11, 13, 15)},
    {WEIR_LANES(0, 1, 4, 5, 8, 9, 12, 13), WEIR_LANES(2, 3, 6, 7, 10, 11, 14, 15)},
    {WEIR_LANES(0, 1, 2, kNothingHere, 8, 9, 10, kNothingHere),
     WEIR_LANES(3, 4, 5, kNothingHere, 11, 12, 13, kNothingHere)},
    {WEIR_LANES(0, 1, 2, 3, 8, 9, 10, 11), WEIR_LANES(4, 5, 6, 7, 12, 13, 14, 15)}};
#undef WEIR_LANES
#undef WEIR_LANE

// (1 - share) * first + share * second, times 128.
template <class Vector>
Vector blended(Vector first, Vector second, Vector shares) {
  const auto difference = hn::ShiftLeft<7>(hn::Sub(first, second));
  return hn::Add(hn::ShiftLeft<7>(first), hn::MulFixedPoint15(difference, shares));
}

void BlendPairs(const std::byte* const* pairs, size_t row_count, const PairColumns& columns,
                int16_t row_share, int16_t* out) {
  const S d;
  const size_t step = columns.step;
  const auto first = hn::LoadDup128(B(), kLanes[step - 1][0]);
  const auto second = hn::LoadDup128(B(), kLanes[step - 1][1]);
  const auto down = hn::Set(d, row_share);
  const size_t lanes = columns.count * pair_lanes(step);
  for (size_t i = 0; i < lanes; i += hn::Lanes(d)) {
    const auto shares = hn::LoadU(d, columns.shares.data() + i);
    const auto row = [&](const std::byte* from) {
      const auto bytes = hn::LoadU(B(), reinterpret_cast<const uint8_t*>(from) + 2 * i);
      return blended(hn::BitCast(d, hn::TableLookupBytesOr0(bytes, first)),
                     hn::BitCast(d, hn::TableLookupBytesOr0(bytes, second)), shares);
    };
    auto value = row(pairs[0]);
    if (row_count == 2)
      value = hn::Add(value, hn::MulFixedPoint15(hn::Sub(value, row(pairs[1])), down));
    hn::StoreU(value, d, out + i);
  }
}

// As many blocks as a vector holds; one if the vector length is known only at run time.
constexpr size_t kBlocks = HWY_HAVE_SCALABLE ? 1 : hn::MaxLanes(B()) / kWindow;
static_assert(kBlocks <= kBlocksPadded);

template <size_t blocks>
auto load_windows(const uint8_t* row, const uint32_t* windows) {
  const hn::FixedTag<uint8_t, blocks * kWindow> d;
  if constexpr (blocks == 1)
    return hn::LoadU(d, row + windows[0]);
  else
    return hn::Combine(d, load_windows<blocks / 2>(row, windows + blocks / 2),
                       load_windows<blocks / 2>(row, windows));
}

template <size_t parts>
void blend_windows(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                   int16_t* out) {
  const hn::FixedTag<uint8_t, kBlocks * kWindow> bytes;
  const hn::Repartition<int16_t, decltype(bytes)> d;
  const auto down = hn::Set(d, row_share);
  const size_t lanes = columns.count * pair_lanes(columns.step);
  const int16_t* const shares = columns.shares.data();
  const uint8_t *const above = from.rows[0], *const below = from.rows[from.count - 1];
  const uint8_t *const next_above = from.next[0], *const next_below = from.next[from.count - 1];
  const uint32_t* windows[2] = {columns.windows[0].data(), columns.windows[1].data()};
  const uint8_t* lookup[2][2];
  for (size_t p = 0; p < parts; ++p)
    for (size_t sample = 0; sample < 2; ++sample)
      lookup[p][sample] = columns.lookup[p][sample].data();
  for (size_t i = 0; i < lanes; i += hn::Lanes(d)) {
    const size_t block = i / kBlockLanes;
    const auto share = hn::LoadU(d, shares + i);
    // The samples of two blocks span about 64 bytes at most.
    for (size_t b = 0; b < kBlocks; b += 2) {
      __builtin_prefetch(next_above + windows[0][block + b]);
      __builtin_prefetch(next_below + windows[0][block + b]);
    }
    const auto row = [&](const uint8_t* in) {
      const auto window = load_windows<kBlocks>(in, windows[0] + block);
      const auto sample = [&](size_t which) {
        return hn::TableLookupBytesOr0(window, hn::LoadU(bytes, lookup[0][which] + 2 * i));
      };
      auto first = sample(0), second = sample(1);
      if constexpr (parts == 2) {
        const auto other = load_windows<kBlocks>(in, windows[1] + block);
        const auto other_sample = [&](size_t which) {
          return hn::TableLookupBytesOr0(other, hn::LoadU(bytes, lookup[1][which] + 2 * i));
        };
        first = hn::Or(first, other_sample(0));
        second = hn::Or(second, other_sample(1));
      }
      return blended(hn::BitCast(d, first), hn::BitCast(d, second), share);
    };
    auto value = row(above);
    if (from.count == 2)
      value = hn::Add(value, hn::MulFixedPoint15(hn::Sub(value, row(below)), down));
    hn::StoreU(value, d, out + i);
  }
}

void BlendWindows(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                  int16_t* out) {
  if (columns.parts() == 1) return blend_windows<1>(from, columns, row_share, out);
  blend_windows<2>(from, columns, row_share, out);
}

#endif

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(BlendPairs);
HWY_EXPORT(BlendWindows);

namespace {

// Copies pairs one by one, for pairs that are far apart.
template <class Pair, class Read>
void sample(const SourceRows& from, const PairColumns& columns, std::byte* const* out,
            Read read) noexcept {
  const uint8_t *above = from.rows[0], *below = from.rows[from.count - 1];
  const uint8_t *next_above = from.next[0], *next_below = from.next[from.count - 1];
  std::byte *to_above = out[0], *to_below = out[from.count - 1];
  for (size_t t = 0; t < columns.count; ++t) {
    __builtin_prefetch(next_above + columns.at[t]);
    __builtin_prefetch(next_below + columns.at[t]);
    const Pair pair = read(above + columns.at[t]), other = read(below + columns.at[t]);
    std::memcpy(to_above + t * sizeof(Pair), &pair, sizeof(Pair));
    std::memcpy(to_below + t * sizeof(Pair), &other, sizeof(Pair));
  }
}

template <class Word>
Word word_at(const uint8_t* at) noexcept {
  Word word;
  std::memcpy(&word, at, sizeof(word));
  return word;
}

// Reads six bytes and not one more: the row may end there.
uint64_t six_bytes_at(const uint8_t* at) noexcept {
  const auto low = word_at<uint32_t>(at);
  const auto high = word_at<uint16_t>(at + 4);
  if constexpr (std::endian::native == std::endian::little)
    return low | uint64_t{high} << 32;
  else
    return uint64_t{low} << 32 | uint64_t{high} << 16;
}

void sample_pairs(const SourceRows& from, const PairColumns& columns,
                  std::byte* const* out) noexcept {
  if (columns.step == 1) return sample<uint16_t>(from, columns, out, word_at<uint16_t>);
  if (columns.step == 2) return sample<uint32_t>(from, columns, out, word_at<uint32_t>);
  if (columns.step == 3) return sample<uint64_t>(from, columns, out, six_bytes_at);
  sample<uint64_t>(from, columns, out, word_at<uint64_t>);
}

}  // namespace

void blend_pairs(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                 std::byte* const* pairs, int16_t* out) noexcept {
  if (columns.wide > 0) return blend_wide_windows(from, columns, row_share, out);
  if (columns.group > 1) return HWY_DYNAMIC_DISPATCH(BlendWindows)(from, columns, row_share, out);
  sample_pairs(from, columns, pairs);
  HWY_DYNAMIC_DISPATCH(BlendPairs)(pairs, from.count, columns, row_share, out);
}

}  // namespace weir::preprocess
#endif
