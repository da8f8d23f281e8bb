// A table of bytes with few steps, as a sum of comparisons.
#include <cstring>

#include "core/transform/stand_table.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/stand_steps.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::ScalableTag<uint8_t>;

HWY_INLINE hn::Vec<Tag> climbed(std::span<const TableStep> steps, hn::Vec<Tag> start,
                                hn::Vec<Tag> x) noexcept {
  const Tag d;
  auto sum = start;
  for (const auto& step : steps) {
    const auto reached = hn::Eq(hn::Max(x, hn::Set(d, step.first)), x);
    sum = hn::Add(sum, hn::IfThenElseZero(reached, hn::Set(d, step.change)));
  }
  return sum;
}

void RunSteps(std::span<const TableStep> steps, uint8_t first, size_t count,
              const std::byte* in_bytes, std::byte* out_bytes) {
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  const auto* in = reinterpret_cast<const uint8_t*>(in_bytes);
  auto* out = reinterpret_cast<uint8_t*>(out_bytes);
  const auto start = hn::Set(d, first);
  size_t i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    const auto a = hn::LoadU(d, in + i), b = hn::LoadU(d, in + i + lanes);
    hn::StoreU(climbed(steps, start, a), d, out + i);
    hn::StoreU(climbed(steps, start, b), d, out + i + lanes);
  }
  for (; i < count; ++i) {
    uint8_t sum = first;
    for (const auto& step : steps)
      sum = static_cast<uint8_t>(sum + (in[i] >= step.first ? step.change : 0));
    out[i] = sum;
  }
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunSteps);

void run_table_steps(std::span<const TableStep> steps, uint8_t start, size_t count, bool accelerate,
                     const std::byte* in, std::byte* out) noexcept {
  if (accelerate)
    HWY_DYNAMIC_DISPATCH(RunSteps)(steps, start, count, in, out);
  else
    HWY_STATIC_DISPATCH(RunSteps)(steps, start, count, in, out);
}

}  // namespace weir::transform
#endif
