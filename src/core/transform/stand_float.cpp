// Computes |x - mean| / deviation or x - mean in float32: load, convert, three or four operations,
// store.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/simd/dispatch.hpp"
#include "core/transform/stand_scale.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/transform/stand_float.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // compiles this file once per CPU target
#include <hwy/highway.h>

#include "core/transform/load_floats-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace weir::transform::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t kMaxLanes = 16;
using Tag = hn::CappedTag<float, kMaxLanes>;
using Vector = hn::Vec<Tag>;

// mean = high + low; by = 1 / deviation. One of each for every element of a vector of every phase.
struct alignas(64) Operands {
  float high[kFewChannels * kMaxLanes], low[kFewChannels * kMaxLanes], by[kFewChannels * kMaxLanes];
};

inline void fill(Operands& to, const StandScale& scale, size_t channels, bool divides) noexcept {
  for (size_t i = 0; i < kFewChannels * kMaxLanes; ++i) {
    const double mean = scale.mean[i % channels];
    to.high[i] = static_cast<float>(mean);
    to.low[i] = static_cast<float>(mean - static_cast<double>(to.high[i]));
    to.by[i] = divides ? static_cast<float>(1 / scale.deviation[i % channels]) : 1.0f;
  }
}

struct Scaler {
  Vector high, low, by;
  Scaler(const Operands& operands, size_t phase) noexcept {
    const Tag d;
    const size_t at = phase * hn::Lanes(d);
    high = hn::LoadU(d, operands.high + at);
    low = hn::LoadU(d, operands.low + at);
    by = hn::LoadU(d, operands.by + at);
  }
  template <bool kDivides>
  HWY_INLINE Vector scaled(Vector x) const noexcept {
    const auto distance = hn::Sub(hn::Sub(x, high), low);
    if constexpr (kDivides)
      return hn::Mul(hn::Abs(distance), by);
    else
      return distance;
  }
};

// The elements after the last whole row of vectors. Compiled once for all ways to scale rows.
template <bool kDivides, class From>
HWY_NOINLINE void scale_rest(const Operands& operands, const From* in, float* out,
                             size_t count) noexcept {
  for (size_t i = 0; i < count; ++i) {
    From element;
    std::memcpy(&element, in + i, sizeof(From));
    const float distance = (static_cast<float>(element) - operands.high[i]) - operands.low[i];
    const float result = kDivides ? std::fabs(distance) * operands.by[i] : distance;
    std::memcpy(out + i, &result, sizeof(float));
  }
}

// NOLINTBEGIN(readability-function-cognitive-complexity): most branches are of the compiler, and
// the loop over vectors keeps the scalers in registers kPhases: vectors after which the operands
// repeat, all of them in registers; 0: any number.
template <bool kDivides, bool kStreamed, size_t kPhases, class From>
void scale_rows(const Operands& operands, size_t phases, const From* in, float* out,
                size_t count) noexcept {
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  const size_t row = phases * lanes;
  const Scaler a(operands, 0), b(operands, kPhases > 1 ? 1 : 0), c(operands, kPhases > 2 ? 2 : 0);
  const auto step = [&](const Scaler& scaler, size_t at) HWY_ATTR {
    store_floats<kStreamed>(scaler.template scaled<kDivides>(load_floats(d, in + at)), d, out + at);
  };
  size_t i = 0;
  // Several loads before their stores: a load at a multiple of 4096 bytes after a pending store
  // would wait for that store.
  if constexpr (kPhases > 0) {
    constexpr size_t kVectors = kPhases == 1 ? 8 : 2 * kPhases;
    for (; i + kVectors * lanes <= count; i += kVectors * lanes) {
      Vector x[kVectors];
      HWY_UNROLL(8)
      for (size_t k = 0; k < kVectors; ++k) x[k] = load_floats(d, in + i + k * lanes);
      HWY_UNROLL(8)
      for (size_t k = 0; k < kVectors; ++k) {
        const Scaler& scaler = k % kPhases == 0 ? a : k % kPhases == 1 ? b : c;
        store_floats<kStreamed>(scaler.template scaled<kDivides>(x[k]), d, out + i + k * lanes);
      }
    }
  }
  for (; i + row <= count; i += row) {
    if constexpr (kPhases > 0) {
      step(a, i);
      if constexpr (kPhases > 1) step(b, i + lanes);
      if constexpr (kPhases > 2) step(c, i + 2 * lanes);
    } else {
      for (size_t phase = 0; phase < phases; ++phase)
        step(Scaler(operands, phase), i + phase * lanes);
    }
  }
  if constexpr (kStreamed) hwy::FlushStream();
  scale_rest<kDivides>(operands, in + i, out + i, count - i);
}
// NOLINTEND(readability-function-cognitive-complexity)

template <bool kDivides, bool kStreamed, class From>
void scale_phases(const Operands& operands, const StandTensor& tensor, const From* in,
                  float* out) noexcept {
  const size_t phases = tensor.channels / std::gcd(tensor.channels, hn::Lanes(Tag()));
  if (phases == 1) return scale_rows<kDivides, kStreamed, 1>(operands, 1, in, out, tensor.count);
  if (phases == 3) return scale_rows<kDivides, kStreamed, 3>(operands, 3, in, out, tensor.count);
  scale_rows<kDivides, kStreamed, 0>(operands, phases, in, out, tensor.count);
}

template <bool kDivides, class From>
void scale_typed(const Operands& operands, const StandTensor& tensor, const std::byte* in_bytes,
                 std::byte* out_bytes) noexcept {
  // Loads and stores are Highway's unaligned ones or memcpy; the cast pointers are never
  // dereferenced.
  const From* in = reinterpret_cast<const From*>(in_bytes);
  float* out = reinterpret_cast<float*>(out_bytes);
  if (worth_streaming(Tag(), in, out, tensor.count))
    scale_phases<kDivides, true>(operands, tensor, in, out);
  else
    scale_phases<kDivides, false>(operands, tensor, in, out);
}

void RunStandFloat(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                   const std::byte* in, std::byte* out) {
  Operands operands;
  fill(operands, scale, tensor.channels, types.divides);
  visit_type(types.from, [&](auto tag) HWY_ATTR {
    using From = typename decltype(tag)::type;
    if constexpr (std::is_same_v<From, float> || (std::is_integral_v<From> && sizeof(From) <= 2)) {
      if (types.divides)
        scale_typed<true, From>(operands, tensor, in, out);
      else
        scale_typed<false, From>(operands, tensor, in, out);
    }
  });
}

}  // namespace weir::transform::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace weir::transform {

HWY_EXPORT(RunStandFloat);

// Values far from the limits of float32 neither overflow nor lose digits.
bool scales_in_float(const StandTensor& tensor, const StandTypes& types,
                     const StandScale& scale) noexcept {
  if (types.to != ElementType::Float32) return false;
  for (size_t i = 0; i < tensor.channels; ++i) {
    if (!(std::fabs(scale.mean[i]) <= 0x1p100)) return false;
    const double deviation = types.divides ? scale.deviation[i] : 1.0;
    if (!(deviation >= 0x1p-100 && deviation <= 0x1p100)) return false;
  }
  return true;
}

void run_stand_float(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept {
  WEIR_DISPATCH_IF(accelerate, RunStandFloat)(tensor, types, scale, in, out);
}

}  // namespace weir::transform
#endif
