// Adds bytes eight at a time and 16-bit numbers in pairs. Signed bytes are shifted up by half their
// range, or unsigned words down, so that one kernel serves both.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/narrow_sum.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/condition/narrow_sum.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#ifndef WEIR_NARROW_SUM_ONCE
#define WEIR_NARROW_SUM_ONCE
namespace weir::condition {

inline int64_t sum_words_one_by_one(const uint8_t* in, size_t from, size_t count, uint16_t turned) {
  int64_t total = 0;
  for (size_t i = from; i < count; ++i) {
    uint16_t word;
    std::memcpy(&word, in + 2 * i, sizeof word);
    total += static_cast<int16_t>(word ^ turned);
  }
  return total;
}

}  // namespace weir::condition
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::condition::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
uint64_t sum_bytes(const uint8_t* in, size_t count, uint8_t turned) {
  uint64_t total = 0;
  for (size_t i = 0; i < count; ++i) total += static_cast<uint8_t>(in[i] ^ turned);
  return total;
}
int64_t sum_words(const uint8_t* in, size_t count, uint16_t turned) {
  return sum_words_one_by_one(in, 0, count, turned);
}
#else
uint64_t sum_bytes(const uint8_t* in, size_t count, uint8_t turned) {
  const hn::ScalableTag<uint8_t> d;
  const hn::Repartition<uint64_t, decltype(d)> d64;
  const size_t lanes = hn::Lanes(d);
  const auto turn = hn::Set(d, turned);
  auto even = hn::Zero(d64), odd = hn::Zero(d64);
  size_t i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    even = hn::Add(even, hn::SumsOf8(hn::Xor(hn::LoadU(d, in + i), turn)));
    odd = hn::Add(odd, hn::SumsOf8(hn::Xor(hn::LoadU(d, in + i + lanes), turn)));
  }
  uint64_t total = hn::GetLane(hn::SumOfLanes(d64, hn::Add(even, odd)));
  for (; i < count; ++i) total += static_cast<uint8_t>(in[i] ^ turned);
  return total;
}

int64_t sum_words(const uint8_t* in, size_t count, uint16_t turned) {
  const hn::ScalableTag<uint16_t> d;
  const hn::Repartition<uint8_t, decltype(d)> d8;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RepartitionToWide<decltype(di)> d32;
  constexpr size_t kVectors = 16384;  // each adds two numbers to a lane: times 2^16 is 2^30
  const size_t lanes = hn::Lanes(d), whole = count / lanes;
  const auto turn = hn::Set(d, turned);
  const auto one = hn::Set(di, int16_t{1});
  int64_t total = 0;
  for (size_t done = 0; done < whole; done += kVectors) {
    auto sum = hn::Zero(d32), rest = hn::Zero(d32);
    const size_t end = std::min(done + kVectors, whole);
    for (size_t i = done; i < end; ++i) {
      const auto x = hn::BitCast(d, hn::LoadU(d8, in + 2 * i * lanes));
      sum = hn::ReorderWidenMulAccumulate(d32, hn::BitCast(di, hn::Xor(x, turn)), one, sum, rest);
    }
    for (const auto& part : {sum, rest}) {
      alignas(64) int32_t each[HWY_MAX_BYTES / sizeof(int32_t)];
      hn::Store(part, d32, each);
      for (size_t i = 0; i < hn::Lanes(d32); ++i) total += each[i];
    }
  }
  return total + sum_words_one_by_one(in, whole * lanes, count, turned);
}
#endif

}  // namespace weir::condition::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::condition {

HWY_EXPORT(sum_bytes);
HWY_EXPORT(sum_words);

int64_t sum_of_bytes(std::span<const std::byte> bytes, bool are_signed) noexcept {
  const auto* in = reinterpret_cast<const uint8_t*>(bytes.data());
  const int64_t moved = are_signed ? 0x80 : 0;
  return static_cast<int64_t>(
             HWY_DYNAMIC_DISPATCH(sum_bytes)(in, bytes.size(), static_cast<uint8_t>(moved))) -
         moved * static_cast<int64_t>(bytes.size());
}
int64_t sum_of_words(std::span<const std::byte> bytes, bool are_signed) noexcept {
  const auto* in = reinterpret_cast<const uint8_t*>(bytes.data());
  const size_t count = bytes.size() / 2;
  const int64_t moved = are_signed ? 0 : 0x8000;
  return HWY_DYNAMIC_DISPATCH(sum_words)(in, count, static_cast<uint16_t>(moved)) +
         moved * static_cast<int64_t>(count);
}

}  // namespace weir::condition
#endif
