// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/nonzero.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/tensor/nonzero.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t kStep = 64;

template <class T, bool kSigned>
HWY_INLINE uint64_t load_bits(const std::byte* at) noexcept {
  const hn::CappedTag<T, kStep> d;
  constexpr size_t kLanes = hn::MaxLanes(hn::CappedTag<T, kStep>());
  uint64_t bits = 0;
  for (size_t i = 0; i < kStep; i += kLanes) {
    auto v = hn::LoadU(d, reinterpret_cast<const T*>(at) + i);
    if constexpr (kSigned) v = hn::Add(v, v);  // drops the sign bit
    alignas(8) uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, hn::Ne(v, hn::Zero(d)), bytes);
    uint64_t some;
    std::memcpy(&some, bytes, 8);
    bits |= some << i;
  }
  return bits;
}

// The elements after the last full step.
template <class T, bool kSigned>
HWY_INLINE uint64_t last_bits(const std::byte* at, size_t elements) noexcept {
  alignas(64) std::byte padded[kStep * sizeof(T)] = {};
  std::memcpy(padded, at, elements * sizeof(T));
  return load_bits<T, kSigned>(padded);
}

template <class T, bool kSigned>
size_t count(const std::byte* dense, size_t elements) noexcept {
  size_t found = 0, i = 0;
  for (; i + kStep <= elements; i += kStep)
    found +=
        static_cast<size_t>(__builtin_popcountll(load_bits<T, kSigned>(dense + i * sizeof(T))));
  if (i == elements) return found;
  const uint64_t rest = last_bits<T, kSigned>(dense + i * sizeof(T), elements - i);
  return found + static_cast<size_t>(__builtin_popcountll(rest));
}

template <class T, bool kSigned>
size_t write(const std::byte* dense, size_t elements, size_t max, std::byte* values,
             std::byte* indices) noexcept {
  size_t found = 0;
  const auto take = [&](size_t first, uint64_t bits) {
    for (; bits != 0 && found < max; bits &= bits - 1) {
      const auto index = static_cast<uint32_t>(first + static_cast<size_t>(__builtin_ctzll(bits)));
      std::memcpy(values + found * sizeof(T), dense + size_t{index} * sizeof(T), sizeof(T));
      std::memcpy(indices + found * 4, &index, 4);
      ++found;
    }
  };
  size_t i = 0;
  for (; i + kStep <= elements; i += kStep) take(i, load_bits<T, kSigned>(dense + i * sizeof(T)));
  if (i < elements) take(i, last_bits<T, kSigned>(dense + i * sizeof(T), elements - i));
  return found;
}

template <class F>
size_t by_size(size_t size, bool is_signed, F&& f) {
  switch (size) {
    case 1:
      return f.template operator()<uint8_t, false>();
    case 2:
      return is_signed ? f.template operator()<uint16_t, true>()
                       : f.template operator()<uint16_t, false>();
    case 4:
      return is_signed ? f.template operator()<uint32_t, true>()
                       : f.template operator()<uint32_t, false>();
    default:
      return is_signed ? f.template operator()<uint64_t, true>()
                       : f.template operator()<uint64_t, false>();
  }
}

size_t count_any(size_t size, bool is_signed, const std::byte* dense, size_t elements) {
  return by_size(size, is_signed,
                 [&]<class T, bool kSigned>() { return count<T, kSigned>(dense, elements); });
}
size_t write_any(size_t size, bool is_signed, const std::byte* dense, size_t elements, size_t max,
                 std::byte* values, std::byte* indices) {
  return by_size(size, is_signed, [&]<class T, bool kSigned>() {
    return write<T, kSigned>(dense, elements, max, values, indices);
  });
}

}  // namespace weir::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir {

HWY_EXPORT(count_any);
HWY_EXPORT(write_any);

size_t NonzeroElements::count(const std::byte* dense, size_t elements) const noexcept {
  return HWY_DYNAMIC_DISPATCH(count_any)(size, is_signed, dense, elements);
}
size_t NonzeroElements::write(const std::byte* dense, size_t elements, size_t max,
                              std::byte* values, std::byte* indices) const noexcept {
  return HWY_DYNAMIC_DISPATCH(write_any)(size, is_signed, dense, elements, max, values, indices);
}

}  // namespace weir
#endif
