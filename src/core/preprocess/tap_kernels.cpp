// Applies filter taps along rows; compiled once per CPU target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/tap_kernels.hpp"

#include <algorithm>

#include "core/preprocess/row_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/preprocess/tap_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::preprocess::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::ScalableTag<float>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;
static_assert(hn::MaxLanes(F()) <= kRowBlock);

V load_bytes(F d, const uint8_t* at) {
  const hn::Rebind<uint8_t, F> bytes;
  return hn::ConvertTo(d, hn::PromoteTo(I(), hn::LoadU(bytes, at)));
}

void BlendRows(const SourceRows& from, const float* weights, size_t bytes, float* out) {
  const uint8_t* const* const rows = from.rows;
  const size_t taps = from.count;
  const F d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + 4 * lanes <= bytes; i += 4 * lanes) {
    for (size_t k = 0; k < taps; ++k) __builtin_prefetch(from.next[k] + i);
    const uint8_t* row = rows[0] + i;
    auto a = load_bytes(d, row), b = load_bytes(d, row + lanes);
    auto c = load_bytes(d, row + 2 * lanes), e = load_bytes(d, row + 3 * lanes);
    if (taps > 1) {
      const auto w = hn::Set(d, weights[0]);
      a = hn::Mul(w, a);
      b = hn::Mul(w, b);
      c = hn::Mul(w, c);
      e = hn::Mul(w, e);
    }
    for (size_t k = 1; k < taps; ++k) {
      const auto w = hn::Set(d, weights[k]);
      row = rows[k] + i;
      a = hn::MulAdd(w, load_bytes(d, row), a);
      b = hn::MulAdd(w, load_bytes(d, row + lanes), b);
      c = hn::MulAdd(w, load_bytes(d, row + 2 * lanes), c);
      e = hn::MulAdd(w, load_bytes(d, row + 3 * lanes), e);
    }
    hn::StoreU(a, d, out + i);
    hn::StoreU(b, d, out + i + lanes);
    hn::StoreU(c, d, out + i + 2 * lanes);
    hn::StoreU(e, d, out + i + 3 * lanes);
  }
  for (; i + lanes <= bytes; i += lanes) {
    auto sum = load_bytes(d, rows[0] + i);
    if (taps > 1) sum = hn::Mul(hn::Set(d, weights[0]), sum);
    for (size_t k = 1; k < taps; ++k)
      sum = hn::MulAdd(hn::Set(d, weights[k]), load_bytes(d, rows[k] + i), sum);
    hn::StoreU(sum, d, out + i);
  }
  for (; i < bytes; ++i) {
    auto sum = static_cast<float>(rows[0][i]);
    if (taps > 1) sum *= weights[0];
    for (size_t k = 1; k < taps; ++k) sum += weights[k] * static_cast<float>(rows[k][i]);
    out[i] = sum;
  }
}

// Picks the numbers at `places` from up to four vectors.
template <size_t vectors>
HWY_INLINE V look_up(F d, V first, V second, V third, V fourth, hn::Vec<I> places) {
  const I di;
  const auto lanes = static_cast<int32_t>(hn::Lanes(d));
  const auto within = hn::IndicesFromVec(d, hn::And(places, hn::Set(di, lanes - 1)));
  const auto from = [&](int32_t vector, V in, V otherwise) HWY_ATTR {
    const auto here = hn::Gt(places, hn::Set(di, vector * lanes - 1));
    return hn::IfThenElse(hn::RebindMask(d, here), hn::TableLookupLanes(in, within), otherwise);
  };
  V found = hn::TableLookupLanes(first, within);
  if constexpr (vectors > 1) found = from(1, second, found);
  if constexpr (vectors > 2) found = from(2, third, found);
  if constexpr (vectors > 3) found = from(3, fourth, found);
  return found;
}

// Computes a vector of targets: take(k) returns sample k of each.
template <class Take>
HWY_INLINE V weighted(F d, const float* weights, size_t taps, size_t stride, Take&& take) {
  auto sum = take(0);
  if (taps > 1) sum = hn::Mul(sum, hn::LoadU(d, weights));
  for (size_t k = 1; k < taps; ++k)
    sum = hn::MulAdd(hn::LoadU(d, weights + k * stride), take(k), sum);
  return sum;
}

// For samples that span only `vectors` vectors; the unused ones repeat the last vector.
template <size_t vectors>
V from_window(const float* in, const int32_t* index, const float* weights, size_t taps,
              size_t stride) {
  const F d;
  const I di;
  const auto first = hn::Set(di, index[0]);
  const auto vector = [&](size_t number) HWY_ATTR {
    return hn::LoadU(d, in + index[0] + std::min(number, vectors - 1) * hn::Lanes(d));
  };
  const auto a = vector(0), b = vector(1), c = vector(2), e = vector(3);
  return weighted(d, weights, taps, stride, [&](size_t k) HWY_ATTR {
    const auto places = hn::Sub(hn::LoadU(di, index + k * stride), first);
    return look_up<vectors>(d, a, b, c, e, places);
  });
}

// A gather instruction loads samples one by one, so close samples are looked up in a few whole
// vectors instead, unless vectors are too short for that.
void GatherRow(const float* in, const int32_t* index, const float* weights, size_t taps,
               size_t count, float* out) {
  const F d;
  const I di;
  const size_t lanes = hn::Lanes(d), stride = padded(count);
  const auto vector = [&](const int32_t* at, const float* by) HWY_ATTR {
    if constexpr (hn::MaxLanes(F()) >= 8) {
      const int32_t last = at[(taps - 1) * stride + lanes - 1];
      switch (static_cast<size_t>(last - at[0]) / lanes) {
        case 0:
          return from_window<1>(in, at, by, taps, stride);
        case 1:
          return from_window<2>(in, at, by, taps, stride);
        case 2:
          return from_window<3>(in, at, by, taps, stride);
        case 3:
          return from_window<4>(in, at, by, taps, stride);
        default:
          break;
      }
    }
    return weighted(d, by, taps, stride, [&](size_t k) HWY_ATTR {
      return hn::GatherIndex(d, in, hn::LoadU(di, at + k * stride));
    });
  };
  for (size_t i = 0; i < count; i += lanes) hn::StoreU(vector(index + i, weights + i), d, out + i);
}

// Each pixel is loaded as a vector of four; with three lanes, the fourth belongs to the next pixel.
void GatherPixels(const float* in, const int32_t* index, const float* weights, size_t taps,
                  size_t count, float* const* out) {
#if HWY_TARGET == HWY_SCALAR
  for (size_t l = 0; l < 4; ++l) GatherRow(in + l, index, weights, taps, count, out[l]);
#else
  const F d;
  const hn::FixedTag<float, 4> four;
  const size_t lanes = hn::Lanes(d), stride = padded(count);
  for (size_t i = 0; i < count; i += lanes) {
    float pixels[4 * hn::MaxLanes(F())];
    for (size_t p = 0; p < lanes; ++p) {
      const size_t at = i + p;
      auto sum = hn::LoadU(four, in + index[at]);
      if (taps > 1) sum = hn::Mul(sum, hn::Set(four, weights[at]));
      for (size_t k = stride + at; k < taps * stride; k += stride)
        sum = hn::MulAdd(hn::Set(four, weights[k]), hn::LoadU(four, in + index[k]), sum);
      hn::StoreU(sum, four, pixels + 4 * p);
    }
    V a, b, c, e;
    hn::LoadInterleaved4(d, pixels, a, b, c, e);
    hn::StoreU(a, d, out[0] + i);
    hn::StoreU(b, d, out[1] + i);
    hn::StoreU(c, d, out[2] + i);
    hn::StoreU(e, d, out[3] + i);
  }
#endif
}

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(BlendRows);
HWY_EXPORT(GatherRow);
HWY_EXPORT(GatherPixels);

void blend_rows(const SourceRows& from, const float* weights, size_t bytes, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(BlendRows)(from, weights, bytes, out);
}
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(GatherRow)(in, index, weights, taps, count, out);
}
void gather_pixels(const float* in, const int32_t* index, const float* weights, size_t taps,
                   size_t count, float* const* out) noexcept {
  HWY_DYNAMIC_DISPATCH(GatherPixels)(in, index, weights, taps, count, out);
}

}  // namespace weir::preprocess
#endif
