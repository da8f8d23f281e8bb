// Interleaves short rows: spreads a vector of each input to its places in the rows and ORs the
// results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/merge/interleave.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/merge/interleave.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#ifndef WEIR_INTERLEAVE_ONCE
#define WEIR_INTERLEAVE_ONCE
namespace weir {

constexpr size_t kVector = 16, kMaxInputs = 4;

struct Interleaved {
  const uint8_t* in[kMaxInputs];
  size_t block[kMaxInputs];
  size_t row = 0;   // bytes
  size_t step = 0;  // rows in a vector
  // A multiple of step; leaves room for a vector at the end of each input and the output.
  size_t rows = 0;
  // The source index of each byte of a vector; 0x80: from another input.
  alignas(kVector) uint8_t from[kMaxInputs][kVector];
  uint8_t* out = nullptr;
};

}  // namespace weir
#endif

HWY_BEFORE_NAMESPACE();
namespace weir::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
size_t interleave(const Interleaved&, size_t) {
  return 0;
}
#else
template <size_t kInputs>
size_t interleave_fixed(const Interleaved& plan) noexcept {
  const hn::FixedTag<uint8_t, kVector> d;
  const auto places = [&](size_t i) { return hn::Load(d, plan.from[std::min(i, kInputs - 1)]); };
  const auto first = places(0), second = places(1), third = places(2), fourth = places(3);
  const uint8_t* in[kMaxInputs] = {};
  for (size_t i = 0; i < kInputs; ++i) in[i] = plan.in[i];
  uint8_t* out = plan.out;
  for (size_t row = 0; row < plan.rows; row += plan.step) {
    auto v = hn::Or(hn::TableLookupBytesOr0(hn::LoadU(d, in[0]), first),
                    hn::TableLookupBytesOr0(hn::LoadU(d, in[1]), second));
    if constexpr (kInputs > 2) v = hn::Or(v, hn::TableLookupBytesOr0(hn::LoadU(d, in[2]), third));
    if constexpr (kInputs > 3) v = hn::Or(v, hn::TableLookupBytesOr0(hn::LoadU(d, in[3]), fourth));
    hn::StoreU(v, d, out);  // the next step overwrites the bytes after this step's rows
    for (size_t i = 0; i < kInputs; ++i) in[i] += plan.step * plan.block[i];
    out += plan.step * plan.row;
  }
  return plan.rows;
}

size_t interleave(const Interleaved& plan, size_t inputs) {
  if (inputs == 2) return interleave_fixed<2>(plan);
  return inputs == 3 ? interleave_fixed<3>(plan) : interleave_fixed<4>(plan);
}
#endif

}  // namespace weir::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir {

HWY_EXPORT(interleave);

size_t interleave_rows(std::span<const std::span<const std::byte>> inputs,
                       std::span<const size_t> blocks, size_t rows, std::byte* out) noexcept {
  const size_t row = std::accumulate(blocks.begin(), blocks.end(), size_t{0});
  if (blocks.size() < 2 || blocks.size() > kMaxInputs || row > kVector) return 0;
  const size_t min = *std::min_element(blocks.begin(), blocks.end());
  if (min == 0) return 0;
  const size_t tail = (kVector + min - 1) / min;
  if (rows <= tail) return 0;
  Interleaved plan;
  plan.row = row;
  plan.step = kVector / row;
  plan.rows = (rows - tail) / plan.step * plan.step;
  plan.out = reinterpret_cast<uint8_t*>(out);
  std::fill_n(plan.from[0], kMaxInputs * kVector, uint8_t{0x80});
  size_t place = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    plan.in[i] = reinterpret_cast<const uint8_t*>(inputs[i].data());
    plan.block[i] = blocks[i];
    for (size_t n = 0; n < plan.step; ++n)
      for (size_t b = 0; b < blocks[i]; ++b)
        plan.from[i][n * row + place + b] = static_cast<uint8_t>(n * blocks[i] + b);
    place += blocks[i];
  }
  return HWY_DYNAMIC_DISPATCH(interleave)(plan, blocks.size());
}

}  // namespace weir
#endif
