// Applies a byte table with few steps as a sum of comparisons.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/simd/dispatch.hpp"
#include "core/transform/stand_table.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/stand_steps.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::ScalableTag<uint8_t>;

// min(x -| (at - 1), 1) is 1 from `at` on, where -| is saturating subtraction.
void RunSteps(const TableSteps& steps, size_t count, const std::byte* in_bytes,
              std::byte* out_bytes) {
  constexpr size_t kVectors = 4;
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  const auto* in = reinterpret_cast<const uint8_t*>(in_bytes);
  auto* out = reinterpret_cast<uint8_t*>(out_bytes);
  const size_t ups = steps.ups, all = steps.ups + steps.downs;
  const auto first = hn::Set(d, steps.first), one = hn::Set(d, uint8_t{1});
  size_t i = 0;
  for (; i + kVectors * lanes <= count; i += kVectors * lanes) {
    const auto a = hn::LoadU(d, in + i), b = hn::LoadU(d, in + i + lanes);
    const auto c = hn::LoadU(d, in + i + 2 * lanes), e = hn::LoadU(d, in + i + 3 * lanes);
    auto sum_a = first, sum_b = first, sum_c = first, sum_e = first;
    for (size_t n = 0; n < ups; ++n) {
      const auto below = hn::Set(d, steps.below[n]);
      sum_a = hn::Add(sum_a, hn::Min(hn::SaturatedSub(a, below), one));
      sum_b = hn::Add(sum_b, hn::Min(hn::SaturatedSub(b, below), one));
      sum_c = hn::Add(sum_c, hn::Min(hn::SaturatedSub(c, below), one));
      sum_e = hn::Add(sum_e, hn::Min(hn::SaturatedSub(e, below), one));
    }
    for (size_t n = ups; n < all; ++n) {
      const auto below = hn::Set(d, steps.below[n]);
      sum_a = hn::Sub(sum_a, hn::Min(hn::SaturatedSub(a, below), one));
      sum_b = hn::Sub(sum_b, hn::Min(hn::SaturatedSub(b, below), one));
      sum_c = hn::Sub(sum_c, hn::Min(hn::SaturatedSub(c, below), one));
      sum_e = hn::Sub(sum_e, hn::Min(hn::SaturatedSub(e, below), one));
    }
    hn::StoreU(sum_a, d, out + i);
    hn::StoreU(sum_b, d, out + i + lanes);
    hn::StoreU(sum_c, d, out + i + 2 * lanes);
    hn::StoreU(sum_e, d, out + i + 3 * lanes);
  }
  for (; i < count; ++i) {
    uint8_t sum = steps.first;
    for (size_t n = 0; n < all; ++n)
      if (in[i] > steps.below[n]) sum = static_cast<uint8_t>(n < ups ? sum + 1 : sum - 1);
    out[i] = sum;
  }
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunSteps);

void run_table_steps(const TableSteps& steps, size_t count, bool accelerate, const std::byte* in,
                     std::byte* out) noexcept {
  WEIR_DISPATCH_IF(accelerate, RunSteps)(steps, count, in, out);
}

}  // namespace weir::transform
#endif
