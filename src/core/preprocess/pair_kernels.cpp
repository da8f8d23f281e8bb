// One source for all vector widths: compiled once per CPU target. 16 bits: 128 times a byte, and
// its differences, fit and are rounded to 1/128 of a step of 255.
#include "core/preprocess/pair_kernels.hpp"

#include <bit>
#include <cstring>

#include "core/preprocess/row_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/pair_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // no vector to look bytes up in

int16_t share_of(int difference, int16_t share) {
  return static_cast<int16_t>((difference * share + (1 << 14)) >> 15);
}

void BlendPairs(const std::byte* const* pairs, size_t row_count, const PairColumns& columns,
                int16_t row_share, int16_t* out) {
  const size_t step = columns.step, lanes = pair_lanes(step);
  for (size_t i = 0; i < columns.count * lanes; ++i) {
    if (i % lanes >= step) continue;
    const auto at = [&](size_t row) {
      const std::byte* pair = pairs[row] + i / lanes * pair_bytes(step) + i % lanes;
      const int first = 128 * std::to_integer<int>(pair[0]);
      return first + share_of(first - 128 * std::to_integer<int>(pair[step]), columns.shares[i]);
    };
    const int value = at(0);
    out[i] =
        static_cast<int16_t>(row_count == 2 ? value + share_of(value - at(1), row_share) : value);
  }
}

void SampleGroups(const uint8_t* const* rows, size_t row_count, const PairColumns& columns,
                  std::byte* const* out) {
  const size_t bytes = pair_bytes(columns.step);
  for (size_t row = 0; row < row_count; ++row)
    for (size_t t = 0; t < columns.count; ++t)
      std::memcpy(out[row] + t * bytes, rows[row] + columns.at[t], 2 * columns.step);
}

#else

using S = hn::ScalableTag<int16_t>;
using B = hn::Repartition<uint8_t, S>;
using V = hn::Vec<S>;
static_assert(hn::MaxLanes(S()) <= kRowBlock);

// Where the bytes of 16 bytes of pairs go, as lanes of 16 bits: the first samples, the second ones.
constexpr uint8_t kNone = 0x80;
#define WEIR_LANES(a, b, c, d, e, f, g, h) \
  { a, kNone, b, kNone, c, kNone, d, kNone, e, kNone, f, kNone, g, kNone, h, kNone }
alignas(16) constexpr uint8_t kLanes[4][2][16] = {
    {WEIR_LANES(0, 2, 4, 6, 8, 10, 12, 14), WEIR_LANES(1, 3, 5, 7, 9, 11, 13, 15)},
    {WEIR_LANES(0, 1, 4, 5, 8, 9, 12, 13), WEIR_LANES(2, 3, 6, 7, 10, 11, 14, 15)},
    {WEIR_LANES(0, 1, 2, kNone, 8, 9, 10, kNone), WEIR_LANES(3, 4, 5, kNone, 11, 12, 13, kNone)},
    {WEIR_LANES(0, 1, 2, 3, 8, 9, 10, 11), WEIR_LANES(4, 5, 6, 7, 12, 13, 14, 15)}};
#undef WEIR_LANES

// One row: (1 - share) * first + share * second, times 128.
template <class Table>
V blended(const std::byte* pairs, Table first, Table second, V shares) {
  const auto bytes = hn::LoadU(B(), reinterpret_cast<const uint8_t*>(pairs));
  const auto a = hn::BitCast(S(), hn::TableLookupBytesOr0(bytes, first));
  const auto b = hn::BitCast(S(), hn::TableLookupBytesOr0(bytes, second));
  return hn::Add(hn::ShiftLeft<7>(a), hn::MulFixedPoint15(hn::ShiftLeft<7>(hn::Sub(a, b)), shares));
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
    auto value = blended(pairs[0] + 2 * i, first, second, shares);
    if (row_count == 2) {
      const auto below = blended(pairs[1] + 2 * i, first, second, shares);
      value = hn::Add(value, hn::MulFixedPoint15(hn::Sub(value, below), down));
    }
    hn::StoreU(value, d, out + i);
  }
}

void SampleGroups(const uint8_t* const* rows, size_t row_count, const PairColumns& columns,
                  std::byte* const* out) {
  const hn::FixedTag<uint8_t, kWindow> d;
  const size_t bytes = columns.group * pair_bytes(columns.step), groups = columns.windows.size();
  const uint32_t* const windows = columns.windows.data();
  const uint8_t* lookup = columns.lookup.data();
  const uint8_t *above = rows[0], *below = rows[row_count - 1];
  auto* to_above = reinterpret_cast<uint8_t*>(out[0]);
  auto* to_below = reinterpret_cast<uint8_t*>(out[row_count - 1]);
  for (size_t g = 0; g < groups; ++g, lookup += kWindow, to_above += bytes, to_below += bytes) {
    const auto order = hn::LoadU(d, lookup);
    hn::StoreU(hn::TableLookupBytes(hn::LoadU(d, above + windows[g]), order), d, to_above);
    if (row_count == 2)
      hn::StoreU(hn::TableLookupBytes(hn::LoadU(d, below + windows[g]), order), d, to_below);
  }
}

#endif

void SplitLanes(const int16_t* in, size_t lanes, size_t count, float* const* out) {
  const hn::ScalableTag<float> d;
  const hn::Rebind<int16_t, decltype(d)> half;
  const hn::RebindToSigned<decltype(d)> whole;
  const auto store = [&](auto value, float* to) {
    const auto number = hn::ConvertTo(d, hn::PromoteTo(whole, value));
    hn::StoreU(hn::Mul(number, hn::Set(d, 1.0f / 128)), d, to);
  };
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::Vec<decltype(half)> v[4];
    if (lanes == 1) {
      store(hn::LoadU(half, in + i), out[0] + i);
    } else if (lanes == 2) {
      hn::LoadInterleaved2(half, in + 2 * i, v[0], v[1]);
      for (size_t l = 0; l < 2; ++l) store(v[l], out[l] + i);
    } else {
      hn::LoadInterleaved4(half, in + 4 * i, v[0], v[1], v[2], v[3]);
      for (size_t l = 0; l < 4; ++l) store(v[l], out[l] + i);
    }
  }
}

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(SampleGroups);
HWY_EXPORT(BlendPairs);
HWY_EXPORT(SplitLanes);

namespace {

// Pairs that lie far from each other, one by one.
template <class Pair, class Read>
void sample(const uint8_t* const* rows, size_t row_count, const PairColumns& columns,
            std::byte* const* out, Read read) noexcept {
  const uint8_t *above = rows[0], *below = rows[row_count - 1];
  std::byte *to_above = out[0], *to_below = out[row_count - 1];
  for (size_t t = 0; t < columns.count; ++t) {
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

// Six bytes, and not one more.
uint64_t six_bytes_at(const uint8_t* at) noexcept {
  const auto low = word_at<uint32_t>(at);
  const auto high = word_at<uint16_t>(at + 4);
  if constexpr (std::endian::native == std::endian::little)
    return low | uint64_t{high} << 32;
  else
    return uint64_t{low} << 32 | uint64_t{high} << 16;
}

}  // namespace

void sample_pairs(const uint8_t* const* rows, size_t row_count, const PairColumns& columns,
                  std::byte* const* out) noexcept {
  if (columns.group > 1) return HWY_DYNAMIC_DISPATCH(SampleGroups)(rows, row_count, columns, out);
  if (columns.step == 1) return sample<uint16_t>(rows, row_count, columns, out, word_at<uint16_t>);
  if (columns.step == 2) return sample<uint32_t>(rows, row_count, columns, out, word_at<uint32_t>);
  if (columns.step == 3) return sample<uint64_t>(rows, row_count, columns, out, six_bytes_at);
  sample<uint64_t>(rows, row_count, columns, out, word_at<uint64_t>);
}

void blend_pairs(const std::byte* const* pairs, size_t row_count, const PairColumns& columns,
                 int16_t row_share, int16_t* out) noexcept {
  HWY_DYNAMIC_DISPATCH(BlendPairs)(pairs, row_count, columns, row_share, out);
}

void split_lanes(const int16_t* in, size_t lanes, size_t count, float* const* out) noexcept {
  HWY_DYNAMIC_DISPATCH(SplitLanes)(in, lanes, count, out);
}

}  // namespace weir::preprocess
#endif
