// Mean, deviation and result of a strip of any types, each in one pass over memory, block by block
// in the L1 cache.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/simd/dispatch.hpp"
#include "core/transform/chain_program.hpp"
#include "core/transform/float16_bits.hpp"
#include "core/transform/number_rules.hpp"
#include "core/transform/stand_scale.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/stand_strip.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#include "core/transform/cast_block-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {

struct alignas(64) Doubles {
  double at[kChainBlock];
};

inline void add_to(Doubles& sums, const Doubles& x, size_t count) noexcept {
  for (size_t i = 0; i < count; ++i) sums.at[i] += x.at[i];
}

inline void add_squares_to(Doubles& sums, const Doubles& x, const Doubles& mean,
                           size_t count) noexcept {
  for (size_t i = 0; i < count; ++i) {
    const double distance = x.at[i] - mean.at[i];
    sums.at[i] += distance * distance;
  }
}

enum class Finish { Distance, Divide, Multiply };

template <Finish kFinish>
void finish(Doubles& x, const Doubles& mean, const Doubles& by) noexcept {
  for (size_t i = 0; i < kChainBlock; ++i) {
    const double distance = x.at[i] - mean.at[i];
    if constexpr (kFinish == Finish::Distance) x.at[i] = distance;
    if constexpr (kFinish == Finish::Divide) x.at[i] = std::fabs(distance) / by.at[i];
    if constexpr (kFinish == Finish::Multiply) x.at[i] = std::fabs(distance) * by.at[i];
  }
}

Finish finish_for(const StandTypes& types) noexcept {
  if (!types.divides) return Finish::Distance;
  return divides_by_product(types.to) ? Finish::Multiply : Finish::Divide;
}

// Averages the positions of each channel and writes the result back to all of them.
inline void average(Doubles& sums, const StandStrip& strip) noexcept {
  const size_t elements = strip.rows * strip.width + strip.tail;
  const size_t positions = elements / strip.channels;
  const auto number = static_cast<double>(positions);
  for (size_t i = strip.channels; i < strip.width; ++i) sums.at[i % strip.channels] += sums.at[i];
  for (size_t i = 0; i < strip.channels; ++i) sums.at[i] /= number;
  for (size_t i = strip.channels; i < kChainBlock; ++i) sums.at[i] = sums.at[i % strip.channels];
}

CastBlock to_double(ElementType type) noexcept {
  return visit_type(
      type, [](auto tag) -> CastBlock { return cast_block<typename decltype(tag)::type, double>; });
}
CastBlock from_double(ElementType type) noexcept {
  return visit_type(
      type, [](auto tag) -> CastBlock { return cast_block<double, typename decltype(tag)::type>; });
}

class Strip {
 public:
  Strip(const StandStrip& strip, const StandTypes& types, const std::byte* in) noexcept
      : strip_(strip), in_(in), in_bytes_(element_size(types.from)), cast_(to_double(types.from)) {}

  // Calls f(values, count, index of the first one in the tensor) row by row.
  template <class F>
  void for_each_row(F&& f) const noexcept {
    for (size_t row = 0; row < strip_.rows; ++row) visit(f, row, strip_.width);
    if (strip_.tail > 0) visit(f, strip_.rows, strip_.tail);
  }

 private:
  template <class F>
  void visit(F&& f, size_t row, size_t count) const noexcept {
    alignas(64) std::byte source[kChainBlock * 8];
    Doubles x;
    const size_t first = strip_.begin + row * strip_.stride;
    std::memcpy(source, in_ + first * in_bytes_, count * in_bytes_);
    std::memset(source + count * in_bytes_, 0, (kChainBlock - count) * in_bytes_);
    cast_(source, reinterpret_cast<std::byte*>(x.at));
    f(x, count, first);
  }

  const StandStrip& strip_;
  const std::byte* in_;
  size_t in_bytes_;
  CastBlock cast_;
};

void measure(const Strip& rows, const StandStrip& strip, bool divides, Doubles& mean,
             Doubles& deviation) noexcept {
  rows.for_each_row([&](const Doubles& x, size_t count, size_t) { add_to(mean, x, count); });
  average(mean, strip);
  if (!divides) return;
  rows.for_each_row(
      [&](const Doubles& x, size_t count, size_t) { add_squares_to(deviation, x, mean, count); });
  average(deviation, strip);
  for (double& d : deviation.at) d = stand_deviation(d);
}

void spread(const StandScale& scale, size_t channels, Doubles& mean, Doubles& deviation) noexcept {
  for (size_t i = 0; i < kChainBlock; ++i) {
    mean.at[i] = scale.mean[i % channels];
    deviation.at[i] = scale.deviation[i % channels];
  }
}

void RunStandStrip(const StandStrip& strip, const StandTypes& types, const StandScale* scale,
                   const std::byte* in, std::byte* out) {
  const Strip rows(strip, types, in);
  Doubles mean{}, deviation{};
  if (scale)
    spread(*scale, strip.channels, mean, deviation);
  else
    measure(rows, strip, types.divides, mean, deviation);
  const Finish how = finish_for(types);
  if (how == Finish::Multiply)
    for (double& d : deviation.at) d = 1 / d;
  const auto cast = from_double(types.to);
  const size_t out_bytes = element_size(types.to);
  rows.for_each_row([&](Doubles& x, size_t count, size_t first) {
    alignas(64) std::byte result[kChainBlock * 8];
    if (how == Finish::Distance) finish<Finish::Distance>(x, mean, deviation);
    if (how == Finish::Divide) finish<Finish::Divide>(x, mean, deviation);
    if (how == Finish::Multiply) finish<Finish::Multiply>(x, mean, deviation);
    cast(reinterpret_cast<const std::byte*>(x.at), result);
    std::memcpy(out + first * out_bytes, result, count * out_bytes);
  });
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunStandStrip);

void run_stand_strip(const StandStrip& strip, const StandTypes& types, const StandScale* scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept {
  WEIR_DISPATCH_IF(accelerate, RunStandStrip)(strip, types, scale, in, out);
}

}  // namespace weir::transform
#endif
