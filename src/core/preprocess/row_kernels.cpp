// Finishes rows of tensors; compiled once per CPU target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/row_kernels.hpp"

#include <algorithm>
#include <cstring>

#include "core/transform/float16_bits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/row_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;
static_assert(hn::MaxLanes(F()) <= kRowBlock);

template <size_t samples>
HWY_INLINE V convert_color(F d, const ColorTransform& t, size_t channel, V a, V b, V c) {
  const float* const of = t.of[channel];
  auto sum = hn::MulAdd(hn::Set(d, of[0]), a, hn::Set(d, t.add[channel]));
  if constexpr (samples == 3)
    sum = hn::MulAdd(hn::Set(d, of[2]), c, hn::MulAdd(hn::Set(d, of[1]), b, sum));
  return hn::Min(hn::Max(sum, hn::Zero(d)), hn::Set(d, 255.0f));
}

// Subtracts, then multiplies: the same rounding as tensor_transform's add and mul.
HWY_INLINE V number(F d, const NumberRule& rule, V color) {
  return hn::Mul(hn::Sub(color, hn::Set(d, rule.mean)), hn::Set(d, rule.scale));
}

// Calls vector(i, place) for each whole vector of `count` numbers, to store a vector at `place`,
// and once more for the rest, of which only the rest is copied to `out`.
template <class T, class Store>
void store_exactly(size_t lanes, size_t step, size_t count, T* out, Store&& vector) {
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) vector(i, out + step * i);
  if (i == count) return;
  T rest[3 * hn::MaxLanes(hn::ScalableTag<T>())];
  vector(i, rest);
  std::memcpy(static_cast<void*>(out + step * i), rest, step * (count - i) * sizeof(T));
}

// Computes vectors of pixels from `first` on and writes out[c], or all channels interleaved to
// out[0].
template <size_t samples, size_t channels>
void finish_vectors(const float* const* in, const ColorTransform& t, const NumberRule* rules,
                    bool together, size_t first, size_t vectors, float* const* out) {
  const F d;
  const size_t lanes = hn::Lanes(d);
  for (size_t at = 0; at < vectors * lanes; at += lanes) {
    auto a = hn::LoadU(d, in[0] + first + at), b = a, c = a;
    if constexpr (samples == 3) {
      b = hn::LoadU(d, in[1] + first + at);
      c = hn::LoadU(d, in[2] + first + at);
    }
    if (t.computed) {
      const auto x = a, y = b, z = c;
      a = convert_color<samples>(d, t, 0, x, y, z);
      if constexpr (channels == 3) {
        b = convert_color<samples>(d, t, 1, x, y, z);
        c = convert_color<samples>(d, t, 2, x, y, z);
      }
    }
    a = number(d, rules[0], a);
    if constexpr (channels == 3) {
      b = number(d, rules[1], b);
      c = number(d, rules[2], c);
      if (together) {
        hn::StoreInterleaved3(a, b, c, d, out[0] + 3 * at);
        continue;
      }
      hn::StoreU(b, d, out[1] + at);
      hn::StoreU(c, d, out[2] + at);
    }
    hn::StoreU(a, d, out[0] + at);
  }
}

template <size_t samples, size_t channels>
void finish(const float* const* in, const ColorTransform& t, const NumberRule* rules,
            const FloatTarget& to, size_t count) {
  const auto run = [&](size_t first, size_t vectors, float* const* out) {
    finish_vectors<samples, channels>(in, t, rules, to.together, first, vectors, out);
  };
  const size_t lanes = hn::Lanes(F()), whole = count / lanes * lanes;
  const size_t rows = to.together ? 1 : channels, step = channels / rows;
  float* out[channels];
  const auto from = [&](size_t first) {
    for (size_t c = 0; c < rows; ++c) out[c] = to.rows[c] + step * first;
    return out;
  };
  run(0, count / lanes, to.rows);
  if (whole == count) return;
  if (to.padded) return run(whole, 1, from(whole));
  // Overlaps the vector before it.
  if (whole > 0) return run(count - lanes, 1, from(count - lanes));
  constexpr size_t kMax = hn::MaxLanes(F());
  float rest[channels * kMax];
  for (size_t c = 0; c < channels; ++c) out[c] = rest + c * kMax;
  run(0, 1, out);
  for (size_t c = 0; c < rows; ++c)
    std::memcpy(to.rows[c], rest + c * kMax, step * count * sizeof(float));
}

void FinishRow(const float* const* in, const ColorTransform& t, const NumberRule* rules,
               const FloatTarget& to, size_t count) {
  if (t.channels == 3) return finish<3, 3>(in, t, rules, to, count);
  if (t.samples == 3) return finish<3, 1>(in, t, rules, to, count);
  finish<1, 1>(in, t, rules, to, count);
}

template <class T>
void write_integers(const NumberRule& rule, const float* row, size_t count, T* out) {
  const F d;
  const I di;
  const hn::Rebind<T, F> bytes;
  const auto bound = hn::Set(d, 65536.0f);
  store_exactly(hn::Lanes(d), 1, count, out, [&](size_t i, T* to) {
    const auto value = hn::Div(number(d, rule, hn::LoadU(d, row + i)), hn::Set(d, rule.divisor));
    const auto near = hn::Max(hn::Min(value, bound), hn::Neg(bound));
    const auto rounded = hn::Add(hn::NearestInt(near), hn::Set(di, rule.zero_point));
    hn::StoreU(hn::DemoteTo(bytes, rounded), bytes, to);
  });
}

void WriteNumbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                  void* out) {
  const F d;
  if (type == ElementType::UInt8)
    return write_integers(rule, row, count, static_cast<uint8_t*>(out));
  if (type == ElementType::Int8) return write_integers(rule, row, count, static_cast<int8_t*>(out));
  if (type == ElementType::Float32)
    return store_exactly(
        hn::Lanes(d), 1, count, static_cast<float*>(out),
        [&](size_t i, float* to) { hn::StoreU(number(d, rule, hn::LoadU(d, row + i)), d, to); });
  float16 halves[kRowBlock];
  for (size_t i = 0; i < count; i += kRowBlock) {
    for (size_t k = 0; k < kRowBlock; ++k)
      halves[k] = transform::round_to_half((row[i + k] - rule.mean) * rule.scale);
    std::memcpy(static_cast<std::byte*>(out) + i * sizeof(float16), halves,
                std::min(kRowBlock, count - i) * sizeof(float16));
  }
}

template <class T>
void interleave(const void* const* rows, size_t count, void* out) {
  const hn::ScalableTag<T> d;
  const T* a = static_cast<const T*>(rows[0]);
  const T* b = static_cast<const T*>(rows[1]);
  const T* c = static_cast<const T*>(rows[2]);
  store_exactly(hn::Lanes(d), 3, count, static_cast<T*>(out), [&](size_t i, T* to) {
    hn::StoreInterleaved3(hn::LoadU(d, a + i), hn::LoadU(d, b + i), hn::LoadU(d, c + i), d, to);
  });
}
static_assert(hn::MaxLanes(hn::ScalableTag<uint8_t>()) <= kRowBlock);

void InterleaveThree(const void* const* rows, size_t element_bytes, size_t count, void* out) {
  if (element_bytes == 1) return interleave<uint8_t>(rows, count, out);
  if (element_bytes == 2) return interleave<uint16_t>(rows, count, out);
  interleave<uint32_t>(rows, count, out);
}

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(FinishRow);
HWY_EXPORT(WriteNumbers);
HWY_EXPORT(InterleaveThree);

void finish_row(const float* const* in, const ColorTransform& transform, const NumberRule* rules,
                const FloatTarget& to, size_t count) noexcept {
  HWY_DYNAMIC_DISPATCH(FinishRow)(in, transform, rules, to, count);
}
void write_numbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                   void* out) noexcept {
  HWY_DYNAMIC_DISPATCH(WriteNumbers)(rule, type, row, count, out);
}
void interleave_three(const void* const* rows, size_t element_bytes, size_t count,
                      void* out) noexcept {
  HWY_DYNAMIC_DISPATCH(InterleaveThree)(rows, element_bytes, count, out);
}

}  // namespace weir::preprocess
#endif
