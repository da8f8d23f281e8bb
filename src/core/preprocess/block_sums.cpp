// Each level is made of the one before.
#include "core/preprocess/block_sums.hpp"

#include <algorithm>
#include <bit>

#include "core/preprocess/row_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/block_sums.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class From>
void add_plainly(const From* in, size_t step, size_t from, size_t blocks, uint16_t* out) {
  for (size_t b = from; b < blocks; ++b)
    for (size_t l = 0; l < step; ++l)
      out[b * step + l] = static_cast<uint16_t>(in[2 * b * step + l] + in[(2 * b + 1) * step + l]);
}

void AddBytePairs(const uint8_t* in, size_t step, size_t blocks, uint16_t* out) {
  size_t done = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::ScalableTag<uint16_t> d;
  const hn::Repartition<uint8_t, decltype(d)> bytes;
  const size_t lanes = hn::Lanes(d);
  const hn::RepartitionToWide<decltype(d)> wide;
  const auto low = hn::Set(d, uint16_t{0xFF});
  const auto low_half = hn::Set(wide, uint32_t{0xFFFF});
  const auto together = [&](auto pairs) HWY_ATTR {
    const auto x = hn::BitCast(wide, pairs);
    return hn::Add(hn::And(x, low_half), hn::ShiftRight<16>(x));
  };
  if (step <= 2)
    for (; (done + lanes / step) <= blocks; done += lanes / step) {
      const auto x = hn::BitCast(d, hn::LoadU(bytes, in + 2 * done * step));
      const auto even = hn::And(x, low), odd = hn::ShiftRight<8>(x);
      if (step == 1)
        hn::StoreU(hn::Add(even, odd), d, out + done);
      else
        hn::StoreU(hn::BitCast(d, hn::Or(together(even), hn::ShiftLeft<16>(together(odd)))), d,
                   out + 2 * done);
    }
#endif
  add_plainly(in, step, done, blocks, out);
}

// A block is one lane of T.
template <class T>
size_t add_lanes(const uint16_t* in, size_t blocks, uint16_t* out) {
  size_t done = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::ScalableTag<T> d;
  const hn::Repartition<uint16_t, decltype(d)> d16;
  const size_t lanes = hn::Lanes(d);
  for (; done + lanes <= blocks; done += lanes) {
    hn::Vec<decltype(d)> even, odd;
    // Highway's loads and stores are unaligned ones: nothing is read through the pointers.
    hn::LoadInterleaved2(d, reinterpret_cast<const T*>(in) + 2 * done, even, odd);
    hn::StoreU(hn::Add(hn::BitCast(d16, even), hn::BitCast(d16, odd)), d16,
               out + done * (sizeof(T) / 2));
  }
#else
  (void)in, (void)blocks, (void)out;
#endif
  return done;
}

void AddPairs(const uint16_t* in, size_t step, size_t blocks, uint16_t* out) {
  const size_t done = step == 1   ? add_lanes<uint16_t>(in, blocks, out)
                      : step == 2 ? add_lanes<uint32_t>(in, blocks, out)
                      : step == 4 ? add_lanes<uint64_t>(in, blocks, out)
                                  : 0;
  add_plainly(in, step, done, blocks, out);
}

void BlendSums(const uint16_t* const* rows, const float* weights, size_t taps, size_t count,
               float* out) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint16_t, decltype(d)> sums;
  const size_t lanes = hn::Lanes(d);
  const auto load = [&](size_t k, size_t i) HWY_ATTR {
    return hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(sums, rows[k] + i)));
  };
  for (size_t i = 0; i < count; i += lanes) {
    auto sum = hn::Mul(hn::Set(d, weights[0]), load(0, i));
    for (size_t k = 1; k < taps; ++k) sum = hn::MulAdd(hn::Set(d, weights[k]), load(k, i), sum);
    hn::StoreU(sum, d, out + i);
  }
}

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(AddBytePairs);
HWY_EXPORT(AddPairs);
HWY_EXPORT(BlendSums);

void add_byte_pairs(const uint8_t* in, size_t step, size_t blocks, uint16_t* out) noexcept {
  HWY_DYNAMIC_DISPATCH(AddBytePairs)(in, step, blocks, out);
}
void add_pairs(const uint16_t* in, size_t step, size_t blocks, uint16_t* out) noexcept {
  HWY_DYNAMIC_DISPATCH(AddPairs)(in, step, blocks, out);
}
void blend_sums(const uint16_t* const* rows, const float* weights, size_t taps, size_t count,
                float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(BlendSums)(rows, weights, taps, count, out);
}

namespace {

size_t level_of(size_t block) noexcept {
  return static_cast<size_t>(std::countr_zero(block / kLeastBlock));
}

}  // namespace

void BlockSums::want(size_t first_row, size_t end_row, size_t block) noexcept {
  first_row_ = std::min(first_row_, first_row);
  end_row_ = std::max(end_row_, end_row);
  most_ = std::max(most_, block);
  made_ = first_row_;
}

void BlockSums::reserve() {
  if (most_ == 0) return;
  const auto at_least = [](std::vector<uint16_t>* memory, size_t size) {
    if (memory->size() < size) memory->resize(size);
  };
  at_least(&pairs_, width(2));
  for (size_t block = kLeastBlock; block <= most_; block *= 2)
    at_least(&levels_[level_of(block)], width(block) * (end_row_ - first_row_) + kRowBlock);
}

// Level by level, and where no block is left over at the ends of the rows, all of them as one row.
void BlockSums::make(const uint8_t* memory, ptrdiff_t stride, size_t end_row) noexcept {
  if (made_ >= end_row) return;
  const size_t done = made_ - first_row_, rows = end_row - made_;
  uint16_t* to = levels_[0].data() + done * width(kLeastBlock);
  for (; made_ < end_row; ++made_, to += width(kLeastBlock)) {
    const uint8_t* row = memory + static_cast<ptrdiff_t>(made_) * stride;
    add_byte_pairs(row + 2 * begin(2) * step_, step_, end(2) - begin(2), pairs_.data());
    add_pairs(pairs_.data() + skipped(kLeastBlock), step_, end(kLeastBlock) - begin(kLeastBlock),
              to);
  }
  for (size_t block = 2 * kLeastBlock; block <= most_; block *= 2) {
    const uint16_t* from = levels_[level_of(block / 2)].data() + done * width(block / 2);
    to = levels_[level_of(block)].data() + done * width(block);
    const size_t blocks = end(block) - begin(block);
    if (width(block / 2) == 2 * width(block)) {
      add_pairs(from, step_, blocks * rows, to);
      continue;
    }
    for (size_t r = 0; r < rows; ++r)
      add_pairs(from + r * width(block / 2) + skipped(block), step_, blocks, to + r * width(block));
  }
}

const uint16_t* BlockSums::row(size_t row, size_t block) const noexcept {
  return levels_[level_of(block)].data() + (row - first_row_) * width(block);
}

}  // namespace weir::preprocess
#endif
