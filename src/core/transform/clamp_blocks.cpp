// Clamps block by block; the loop has a constant length, so the compiler vectorises it for each
// target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "core/transform/chain_program.hpp"
#include "core/transform/clamp.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/clamp_blocks.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#include "core/transform/float16_bits.hpp"

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {

template <class T>
T clamped(T x, T first, T low, T last, T high) noexcept {
  if constexpr (std::is_same_v<T, float16>) {
    const float value = widen(x);
    const uint16_t above = value > widen(last) ? high.bits : x.bits;
    x.bits = value < widen(first) ? low.bits : above;
    return x;
  } else {
    const T above = x > last ? high : x;
    return x < first ? low : above;
  }
}

template <class T>
void clamp_between(const T* HWY_RESTRICT in, T* HWY_RESTRICT out, size_t count,
                   const Limits<T>& to) noexcept {
  const T first = to.first, low = to.low, last = to.last, high = to.high;
  for (size_t i = 0; i < count; ++i) out[i] = clamped(in[i], first, low, last, high);
}

template <class T>
void clamp_in_place(T* x, size_t count, const Limits<T>& to) noexcept {
  const T first = to.first, low = to.low, last = to.last, high = to.high;
  for (size_t i = 0; i < count; ++i) x[i] = clamped(x[i], first, low, last, high);
}

template <class T>
bool is_aligned(const std::byte* at) noexcept {
  return reinterpret_cast<uintptr_t>(at) % alignof(T) == 0;
}

template <class T>
void clamp_all(const std::byte* in, std::byte* out, size_t count, const Limits<T>& to) noexcept {
  if (is_aligned<T>(in) && is_aligned<T>(out)) {
    T* x = reinterpret_cast<T*>(out);
    if (to.fill)
      std::fill_n(x, count, to.low);
    else if (in == out)
      clamp_in_place(x, count, to);
    else
      clamp_between(reinterpret_cast<const T*>(in), x, count, to);
    return;
  }
  T block[kChainBlock];
  for (size_t i = 0; i < count; i += kChainBlock) {
    const size_t length = std::min(kChainBlock, count - i);
    std::memcpy(static_cast<void*>(block), in + i * sizeof(T), length * sizeof(T));
    if (to.fill)
      std::fill_n(block, length, to.low);
    else
      clamp_in_place(block, length, to);
    std::memcpy(out + i * sizeof(T), block, length * sizeof(T));
  }
}

void RunClamp(const std::byte* in, std::byte* out, size_t count, ElementType type,
              const std::byte* limits_bytes) {
  visit_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    Limits<T> limits;
    std::memcpy(static_cast<void*>(&limits), limits_bytes, sizeof(limits));
    clamp_all<T>(in, out, count, limits);
  });
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunClamp);

void run_clamp(const std::byte* in, std::byte* out, size_t count, ElementType type,
               const std::byte* limits) noexcept {
  HWY_DYNAMIC_DISPATCH(RunClamp)(in, out, count, type, limits);
}

}  // namespace weir::transform
#endif
