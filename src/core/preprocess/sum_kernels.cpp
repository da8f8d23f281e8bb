// Adds up blocks of samples, each level from the one before it; compiled once per CPU target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/sum_kernels.hpp"

#include <algorithm>
#include <bit>

#include "core/preprocess/row_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/sum_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Scalar version: adds `rows` rows into blocks of two `From` elements.
template <size_t rows, bool cosited, class From>
void add_plainly(const From* in, ptrdiff_t stride, size_t step, size_t from, size_t blocks,
                 uint16_t* out) {
  for (size_t b = from; b < blocks; ++b)
    for (size_t l = 0; l < step; ++l) {
      const From* at = in + 2 * b * step + l;
      unsigned sum = 0;
      for (size_t r = 0; r < rows; ++r, at += stride) {
        sum += cosited ? 3 * at[0] + 4 * at[step] : at[0] + at[step];
        if (cosited && b + 1 < blocks) sum += at[2 * step];
      }
      out[b * step + l] = static_cast<uint16_t>(sum);
    }
}

#if HWY_TARGET != HWY_SCALAR

constexpr size_t kLine = 64;  // bytes of a cache line

// Adds whole vectors of blocks of three or four lanes; returns the number of blocks done.
template <size_t rows, size_t step>
size_t add_packed_pairs(const uint8_t* in, ptrdiff_t stride, ptrdiff_t next, size_t blocks,
                        uint16_t* out) {
  const hn::ScalableTag<uint16_t> d;
  const hn::Repartition<uint8_t, decltype(d)> bytes;
  const auto add_pairs = [&](auto& sum, auto samples) HWY_ATTR {
    const auto x = hn::BitCast(d, samples);
    sum = hn::Add(sum, hn::Add(hn::And(x, hn::Set(d, uint16_t{0xFF})), hn::ShiftRight<8>(x)));
  };
  size_t done = 0;
  for (; done + hn::Lanes(d) <= blocks; done += hn::Lanes(d)) {
    auto a = hn::Zero(d), b = a, c = a, e = a;
    for (size_t r = 0; r < rows; ++r) {
      const uint8_t* const row = in + static_cast<ptrdiff_t>(r) * stride + 2 * done * step;
      for (size_t at = 0; at < 2 * hn::Lanes(d) * step; at += kLine)
        __builtin_prefetch(row + next + at);
      hn::Vec<decltype(bytes)> w, x, y, z;
      if constexpr (step == 3)
        hn::LoadInterleaved3(bytes, row, w, x, y);
      else
        hn::LoadInterleaved4(bytes, row, w, x, y, z);
      add_pairs(a, w);
      add_pairs(b, x);
      add_pairs(c, y);
      if constexpr (step == 4) add_pairs(e, z);
    }
    if constexpr (step == 3)
      hn::StoreInterleaved3(a, b, c, d, out + done * step);
    else
      hn::StoreInterleaved4(a, b, c, e, d, out + done * step);
  }
  return done;
}

#endif

// `next`: distance in bytes from a row to the row to prefetch (see SourceRows).
template <size_t rows, bool cosited>
void add_byte_pairs(const uint8_t* in, ptrdiff_t stride, [[maybe_unused]] ptrdiff_t next,
                    size_t step, size_t blocks, uint16_t* out) {
  size_t done = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::ScalableTag<uint16_t> d;
  const hn::Repartition<uint8_t, decltype(d)> bytes;
  const size_t lanes = hn::Lanes(d);
  const hn::RepartitionToWide<decltype(d)> wide;
  const auto low = hn::Set(d, uint16_t{0xFF});
  const auto low_half = hn::Set(wide, uint32_t{0xFFFF});
  const auto load = [&](size_t row, size_t at) HWY_ATTR {
    return hn::BitCast(d, hn::LoadU(bytes, in + static_cast<ptrdiff_t>(row) * stride + at));
  };
  // Combines the first samples, the second ones and the ones after the pair.
  const auto weighted = [](auto first, auto second, auto after) HWY_ATTR {
    if constexpr (!cosited) return hn::Add(first, second);
    const auto both = hn::Add(first, second);
    return hn::Add(hn::Add(both, hn::Add(both, both)), hn::Add(second, after));
  };
  // Combines the two adjacent pairs of one lane.
  const auto together = [&](auto pairs, auto after) HWY_ATTR {
    const auto x = hn::BitCast(wide, pairs);
    return weighted(hn::And(x, low_half), hn::ShiftRight<16>(x),
                    hn::And(hn::BitCast(wide, after), low_half));
  };
  // A co-sited sum needs to know which byte is the first sample: the low one in little endian.
  constexpr bool any_order = !cosited || std::endian::native == std::endian::little;
  if (step <= 2 && any_order)
    for (; done + lanes / step + (cosited ? 1 : 0) <= blocks; done += lanes / step) {
      auto even = hn::Zero(d), odd = even, even_after = even, odd_after = even;
      for (size_t r = 0; r < rows; ++r) {
        const auto x = load(r, 2 * done * step);
        __builtin_prefetch(in + static_cast<ptrdiff_t>(r) * stride + next + 2 * done * step);
        even = hn::Add(even, hn::And(x, low));
        odd = hn::Add(odd, hn::ShiftRight<8>(x));
        if constexpr (!cosited) continue;
        const auto after = load(r, 2 * (done + 1) * step);
        even_after = hn::Add(even_after, hn::And(after, low));
        odd_after = hn::Add(odd_after, hn::ShiftRight<8>(after));
      }
      if (step == 1)
        hn::StoreU(weighted(even, odd, even_after), d, out + done);
      else
        hn::StoreU(hn::BitCast(d, hn::Or(together(even, even_after),
                                         hn::ShiftLeft<16>(together(odd, odd_after)))),
                   d, out + 2 * done);
    }
  if (step > 2 && !cosited)
    done = step == 3 ? add_packed_pairs<rows, 3>(in, stride, next, blocks, out)
                     : add_packed_pairs<rows, 4>(in, stride, next, blocks, out);
#endif
  add_plainly<rows, cosited>(in, stride, step, done, blocks, out);
}

// Each block is one element of T. Processes whole vectors, also at the end.
template <class T>
void add_lanes(const uint16_t* in, size_t blocks, uint16_t* out) {
  const hn::ScalableTag<T> d;
  const hn::Repartition<uint16_t, decltype(d)> d16;
  for (size_t b = 0; b < blocks; b += hn::Lanes(d)) {
    hn::Vec<decltype(d)> even, odd;
    // Highway's loads are unaligned; nothing is read through the cast pointers directly.
    hn::LoadInterleaved2(d, reinterpret_cast<const T*>(in) + 2 * b, even, odd);
    hn::StoreU(hn::Add(hn::BitCast(d16, even), hn::BitCast(d16, odd)), d16,
               out + b * (sizeof(T) / 2));
  }
}

void AddPairs(const uint16_t* in, size_t step, size_t blocks, uint16_t* out) {
  size_t done = 0;
#if HWY_TARGET != HWY_SCALAR
  if (step == 1) return add_lanes<uint16_t>(in, blocks, out);
  if (step == 2) return add_lanes<uint32_t>(in, blocks, out);
  if (step == 4) return add_lanes<uint64_t>(in, blocks, out);
  const hn::ScalableTag<uint16_t> d;
  const hn::RepartitionToWide<decltype(d)> wide;
  const hn::Rebind<uint16_t, decltype(wide)> half;
  const auto together = [&](auto pairs) HWY_ATTR {
    const auto x = hn::BitCast(wide, pairs);
    return hn::TruncateTo(half, hn::Add(x, hn::ShiftRight<16>(x)));
  };
  for (; done + hn::Lanes(wide) <= blocks; done += hn::Lanes(wide)) {
    hn::Vec<decltype(d)> a, b, c;
    hn::LoadInterleaved3(d, in + 6 * done, a, b, c);
    hn::StoreInterleaved3(together(a), together(b), together(c), half, out + 3 * done);
  }
#endif
  add_plainly<1, false>(in, 0, step, done, blocks, out);
}

void add_to(const uint16_t* in, size_t count, uint16_t* sum) {
  const hn::ScalableTag<uint16_t> d;
  for (size_t i = 0; i < count; i += hn::Lanes(d))
    hn::StoreU(hn::Add(hn::LoadU(d, in + i), hn::LoadU(d, sum + i)), d, sum + i);
}

template <bool cosited>
void add_byte_pairs(size_t rows, const uint8_t* in, ptrdiff_t stride, ptrdiff_t next, size_t step,
                    size_t blocks, uint16_t* out) {
  static_assert(kRowsTogether == 4);
  constexpr decltype(&add_byte_pairs<1, cosited>) kAdd[] = {
      add_byte_pairs<1, cosited>, add_byte_pairs<2, cosited>, add_byte_pairs<3, cosited>,
      add_byte_pairs<4, cosited>};
  kAdd[rows - 1](in, stride, next, step, blocks, out);
}

void AddRows(const SumRows& rows, size_t step, std::span<SumLevel> levels) {
  const auto add_bytes = rows.cosited ? add_byte_pairs<true> : add_byte_pairs<false>;
  size_t together = 1;
  for (size_t r = rows.first; r < rows.first + rows.count; r += together) {
    for (together = 1; !rows.begins[r + together];) ++together;
    const bool last = r + 2 * together > rows.first + rows.count;
    const ptrdiff_t next = last ? 0 : static_cast<ptrdiff_t>(together) * rows.stride;
    const uint16_t* from = nullptr;
    for (SumLevel& l : levels) {
      const size_t mask = (size_t{1} << l.rows_log2) - 1;
      const bool begins =
          l.sums != nullptr && ((r & mask) == 0 || (r == rows.first && !rows.begun));
      uint16_t* const row = begins ? l.sums : l.row;
      if (from == nullptr)
        add_bytes(together, rows.memory + static_cast<ptrdiff_t>(r) * rows.stride, rows.stride,
                  next, step, l.blocks, row);
      else
        AddPairs(from + l.skipped, step, l.blocks, row);
      from = row;
      if (l.sums == nullptr) continue;
      if (!begins) add_to(row, l.blocks * step, l.sums);
      if (((r + together) & mask) == 0) l.sums += l.stride;
    }
  }
}

#if HWY_TARGET == HWY_SCALAR  // no vector holds the lanes of two blocks

void BlendSums(const SumBlend& blend, size_t step, size_t blocks, float* const* out) {
  const bool alike = blend.first == blend.between && blend.between == blend.last;
  for (size_t i = 0; i < blocks * step; ++i) {
    const auto at = [&](size_t k) { return int32_t{blend.rows[k * blend.stride + i]}; };
    float sum = 0;
    int32_t held = at(0);
    const auto weigh = [&](float weight) {
      sum += weight * static_cast<float>(held);
      held = 0;
    };
    if (!alike) weigh(blend.first);
    for (size_t k = 1; k + 1 < blend.count; ++k) held += at(k);
    if (!alike && blend.count > 2) weigh(blend.between);
    if (blend.count > 1) held += at(blend.count - 1);
    if (alike || blend.count > 1) weigh(blend.last);
    out[i % step][i / step] = sum;
  }
}

#else

void BlendSums(const SumBlend& blend, size_t step, size_t blocks, float* const* out) {
  const bool alike = blend.first == blend.between && blend.between == blend.last;
  const hn::ScalableTag<float> d;
  const hn::RebindToUnsigned<decltype(d)> d32;
  const hn::Repartition<uint16_t, decltype(d)> d16;
  const hn::Half<decltype(d16)> half;
  const hn::RebindToSigned<decltype(d)> whole;
  const size_t lanes = hn::Lanes(d);
  for (size_t i = 0; i < blocks * step; i += 2 * lanes) {
    const uint16_t* row = blend.rows + i;
    auto a = hn::Zero(d), b = a;
    auto low = hn::Zero(whole), high = low;
    const auto split = [&](auto sums) HWY_ATTR {
      if (step == 1) {
        low = hn::Add(low, hn::PromoteTo(whole, hn::LowerHalf(half, sums)));
        high = hn::Add(high, hn::PromoteTo(whole, hn::UpperHalf(half, sums)));
        return;
      }
      const auto both = hn::BitCast(d32, sums);
      low = hn::Add(low, hn::BitCast(whole, hn::And(both, hn::Set(d32, 0xFFFF))));
      high = hn::Add(high, hn::BitCast(whole, hn::ShiftRight<16>(both)));
    };
    const auto weigh = [&](float weight) HWY_ATTR {
      a = hn::MulAdd(hn::Set(d, weight), hn::ConvertTo(d, low), a);
      b = hn::MulAdd(hn::Set(d, weight), hn::ConvertTo(d, high), b);
      low = high = hn::Zero(whole);
    };
    split(hn::LoadU(d16, row));
    if (!alike) weigh(blend.first);
    for (size_t k = 1; k + 1 < blend.count;) {
      auto sums = hn::LoadU(d16, row + k * blend.stride);
      const size_t end = std::min(k + blend.at_once, blend.count - 1);
      while (++k < end) sums = hn::Add(sums, hn::LoadU(d16, row + k * blend.stride));
      split(sums);
    }
    if (!alike && blend.count > 2) weigh(blend.between);
    if (blend.count > 1) split(hn::LoadU(d16, row + (blend.count - 1) * blend.stride));
    if (alike || blend.count > 1) weigh(blend.last);
    hn::StoreU(a, d, step == 1 ? out[0] + i : out[0] + i / 2);
    hn::StoreU(b, d, step == 1 ? out[0] + i + lanes : out[1] + i / 2);
  }
}

#endif

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(AddRows);
HWY_EXPORT(BlendSums);

void add_rows(const SumRows& rows, size_t step, std::span<SumLevel> levels) noexcept {
  HWY_DYNAMIC_DISPATCH(AddRows)(rows, step, levels);
}
void blend_sums(const SumBlend& blend, size_t step, size_t blocks, float* const* out) noexcept {
  HWY_DYNAMIC_DISPATCH(BlendSums)(blend, step, blocks, out);
}

}  // namespace weir::preprocess
#endif
