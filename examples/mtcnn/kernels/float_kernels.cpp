// One source for all vector widths: compiled once per CPU target.
#include "float_kernels.hpp"

#include <algorithm>
#include <array>
#include <utility>

// Vectors are kept in arrays, which those of unknown length cannot be.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "float_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mtcnn::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, kGroup>;
using V = hn::Vec<F>;

// Sums of kPixels pixels times kVectors vectors of channels stay in registers.
#if HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM
constexpr size_t kMostPixels[] = {0, 12, 12, 8, 6};
#else
constexpr size_t kMostPixels[] = {0, 10, 6, 4, 2};
#endif

template <size_t kVectors, size_t kPixels>
HWY_ATTR void Block(const ConvolveRow& row, size_t x, size_t channel) {
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

using BlockFunction = void (*)(const ConvolveRow&, size_t, size_t);
template <size_t kVectors, size_t... kPixels>
constexpr std::array<BlockFunction, sizeof...(kPixels)> blocks(std::index_sequence<kPixels...>) {
  return {&Block<kVectors, kPixels + 1>...};
}

template <size_t kVectors>
void Row(const ConvolveRow& row) {
  constexpr size_t kMost = kMostPixels[kVectors];
  static constexpr auto kBlocks = blocks<kVectors>(std::make_index_sequence<kMost>());
  const size_t step = kVectors * hn::Lanes(F()), end = padded(row.outputs);
  size_t left = (row.pixels + kMost - 1) / kMost;  // blocks of about the same size
  for (size_t x = 0; x < row.pixels; --left) {
    const size_t count = (row.pixels - x + left - 1) / left;
    for (size_t channel = 0; channel < end; channel += step) kBlocks[count - 1](row, x, channel);
    x += count;
  }
}

void Convolve(const ConvolveRow& row) {
  const size_t vectors = padded(row.outputs) / hn::Lanes(F());
  if (vectors % 4 == 0 && row.pixels <= kMostPixels[4]) return Row<4>(row);
  if (vectors % 2 == 0) return Row<2>(row);
  return vectors % 3 == 0 ? Row<3>(row) : Row<1>(row);
}

void Pool(const PoolRow& row) {
  const F d;
  const size_t lanes = hn::Lanes(d), channels = row.channels;
  // Upwards, for what a vector has too many is the next pixel's.
  for (size_t x = 0; x < row.out_pixels; ++x) {
    const size_t first = 2 * x * row.in_step;
    const size_t columns = std::min(row.width, row.in_pixels - 2 * x);
    for (size_t c = 0; c < channels; c += lanes) {
      V most = hn::LoadU(d, row.rows[0] + first + c);
      for (size_t r = 0; r < row.height; ++r)
        for (size_t column = 0; column < columns; ++column)
          most = hn::Max(most, hn::LoadU(d, row.rows[r] + first + column * row.in_step + c));
      hn::StoreU(most, d, row.out + x * row.out_step + c);
    }
  }
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
HWY_EXPORT(Pool);
HWY_EXPORT(Widen);

void convolve(const ConvolveRow& row) {
  HWY_DYNAMIC_DISPATCH(Convolve)(row);
}
void pool(const PoolRow& row) {
  HWY_DYNAMIC_DISPATCH(Pool)(row);
}
void widen(const uint8_t* in, size_t count, float* out) {
  HWY_DYNAMIC_DISPATCH(Widen)(in, count, out);
}

}  // namespace mtcnn::kernels
#endif
