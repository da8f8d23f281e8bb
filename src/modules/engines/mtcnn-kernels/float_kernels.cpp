// float32 kernels: one source, compiled once per CPU target for its vector width.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "float_kernels.hpp"

// Vectors are kept in arrays, which is impossible for scalable vectors.
#undef HWY_DISABLED_TARGETS  // of a sanitizer build
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "float_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace mtcnn::kernels::HWY_NAMESPACE {

using F = hn::CappedTag<float, kGroup>;
using V = hn::Vec<F>;

struct FloatBlocks {
  using Row = ConvolveRow;
// The sums of kPixels pixels times kVectors vectors of channels stay in registers.
#if HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM
  static constexpr size_t kMaxPixels[] = {0, 12, 12, 8, 6};
#else
  static constexpr size_t kMaxPixels[] = {0, 10, 6, 4, 2};
#endif
  static size_t lanes() {
    return hn::Lanes(F());
  }

  // NOLINTBEGIN(readability-function-cognitive-complexity): the sums stay in registers from the
  // first loop to the last one
  template <size_t kVectors, size_t kPixels>
  static HWY_ATTR void block(const Row& row, size_t x, size_t channel) {
    const F d;
    const size_t lanes = hn::Lanes(d), step = row.in_step, stride = padded(row.outputs);
    V sum[kPixels][kVectors];
#pragma GCC unroll 4
    for (size_t v = 0; v < kVectors; ++v) {
      const V bias = hn::LoadU(d, row.bias + channel + v * lanes);
#pragma GCC unroll 16
      for (size_t p = 0; p < kPixels; ++p) sum[p][v] = bias;
    }
    const float* weights = row.weights + channel;
    for (size_t r = 0; r < row.height; ++r) {
      const float* in = row.rows[r] + x * step;
      for (size_t k = 0; k < row.run; ++k, ++in, weights += stride) {
        V weight[kVectors];
#pragma GCC unroll 4
        for (size_t v = 0; v < kVectors; ++v) weight[v] = hn::LoadU(d, weights + v * lanes);
#pragma GCC unroll 16
        for (size_t p = 0; p < kPixels; ++p) {
          const V value = hn::Set(d, in[p * step]);
#pragma GCC unroll 4
          for (size_t v = 0; v < kVectors; ++v) sum[p][v] = hn::MulAdd(value, weight[v], sum[p][v]);
        }
      }
    }
    float* out = row.out + x * stride + channel;
    const V zero = hn::Zero(d);
#pragma GCC unroll 16
    for (size_t p = 0; p < kPixels; ++p) {
#pragma GCC unroll 4
      for (size_t v = 0; v < kVectors; ++v) {
        const V slope = hn::LoadU(d, row.slope + channel + v * lanes);
        const V y = hn::MulAdd(slope, hn::Min(sum[p][v], zero), hn::Max(sum[p][v], zero));
        hn::StoreU(y, d, out + p * stride + v * lanes);
      }
    }
  }
  // NOLINTEND(readability-function-cognitive-complexity)
};

void Convolve(const ConvolveRow& row) {
  const size_t vectors = padded(row.outputs) / hn::Lanes(F());
  if (vectors % 4 == 0 && row.pixels <= FloatBlocks::kMaxPixels[4])
    return in_blocks<FloatBlocks, 4>(row);
  if (vectors % 2 == 0) return in_blocks<FloatBlocks, 2>(row);
  return vectors % 3 == 0 ? in_blocks<FloatBlocks, 3>(row) : in_blocks<FloatBlocks, 1>(row);
}

void PoolFloats(const PoolRow<float>& row) {
  Pool(row);
}

void Widen(const uint8_t* in, size_t count, float* out) {
  const F d;
  const hn::Rebind<uint8_t, F> bytes;
  const hn::RebindToSigned<F> whole;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(bytes, in + i))), d, out + i);
  for (; i < count; ++i) out[i] = static_cast<float>(in[i]);
}

}  // namespace mtcnn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mtcnn::kernels {

HWY_EXPORT(Convolve);
HWY_EXPORT(PoolFloats);
HWY_EXPORT(Widen);

void convolve(const ConvolveRow& row) {
  HWY_DYNAMIC_DISPATCH(Convolve)(row);
}
void pool(const PoolRow<float>& row) {
  HWY_DYNAMIC_DISPATCH(PoolFloats)(row);
}
void widen(const uint8_t* in, size_t count, float* out) {
  HWY_DYNAMIC_DISPATCH(Widen)(in, count, out);
}

}  // namespace mtcnn::kernels
#endif
