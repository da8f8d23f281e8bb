// Applies filter taps along rows; compiled once per CPU target.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/tap_kernels.hpp"

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
    const auto first = hn::Set(d, weights[0]);
    auto a = hn::Mul(first, load_bytes(d, row)), b = hn::Mul(first, load_bytes(d, row + lanes));
    auto c = hn::Mul(first, load_bytes(d, row + 2 * lanes));
    auto e = hn::Mul(first, load_bytes(d, row + 3 * lanes));
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
    auto sum = hn::Mul(hn::Set(d, weights[0]), load_bytes(d, rows[0] + i));
    for (size_t k = 1; k < taps; ++k)
      sum = hn::MulAdd(hn::Set(d, weights[k]), load_bytes(d, rows[k] + i), sum);
    hn::StoreU(sum, d, out + i);
  }
  for (; i < bytes; ++i) {
    float sum = weights[0] * static_cast<float>(rows[0][i]);
    for (size_t k = 1; k < taps; ++k) sum += weights[k] * static_cast<float>(rows[k][i]);
    out[i] = sum;
  }
}

void GatherRow(const float* in, const int32_t* index, const float* weights, size_t taps,
               size_t count, float* out) {
  const F d;
  const I di;
  const size_t stride = padded(count);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    auto sum = hn::Mul(hn::LoadU(d, weights + i), hn::GatherIndex(d, in, hn::LoadU(di, index + i)));
    for (size_t k = stride + i; k < taps * stride; k += stride)
      sum = hn::MulAdd(hn::LoadU(d, weights + k), hn::GatherIndex(d, in, hn::LoadU(di, index + k)),
                       sum);
    hn::StoreU(sum, d, out + i);
  }
}

}  // namespace weir::preprocess::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::preprocess {

HWY_EXPORT(BlendRows);
HWY_EXPORT(GatherRow);

void blend_rows(const SourceRows& from, const float* weights, size_t bytes, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(BlendRows)(from, weights, bytes, out);
}
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(GatherRow)(in, index, weights, taps, count, out);
}

}  // namespace weir::preprocess
#endif
