// One source for all vector widths: compiled once per CPU target.
#include "byte_kernels.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

// Vectors are kept in arrays, which those of unknown length cannot be.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#define HWY_WANT_AVX3_DL  // has VNNI
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "byte_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mtcnn::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using I = hn::CappedTag<int32_t, kGroup>;
using F = hn::RebindToFloat<I>;
using VI = hn::Vec<I>;
using VF = hn::Vec<F>;

#if HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM
constexpr size_t kMostPixels[] = {0, 12, 12, 8};
#else
constexpr size_t kMostPixels[] = {0, 8, 4, 2};
#endif

// sum + a[0] * b[0] + ... + a[3] * b[3] in each lane: bytes of `a` without sign, of `b` with.
HWY_INLINE VI MultiplyQuads(I d, VI a, VI b, VI sum) {
#if HWY_TARGET == HWY_AVX3_DL
  (void)d;  // Highway 1.0.3 does not name the instruction set to the compiler
  asm("vpdpbusd %2, %1, %0" : "+v"(sum.raw) : "v"(a.raw), "v"(b.raw));
  return sum;
#else
  const auto low = hn::Set(d, 255);
  const auto product = [&](VI unsigned_bytes, VI signed_bytes) {
    return hn::Mul(hn::And(unsigned_bytes, low), hn::ShiftRight<24>(signed_bytes));
  };
  sum = hn::Add(sum, product(a, hn::ShiftLeft<24>(b)));
  sum = hn::Add(sum, product(hn::ShiftRight<8>(a), hn::ShiftLeft<16>(b)));
  sum = hn::Add(sum, product(hn::ShiftRight<16>(a), hn::ShiftLeft<8>(b)));
  return hn::Add(sum, product(hn::ShiftRight<24>(a), b));
#endif
}

HWY_INLINE VI Quad(I d, const uint8_t* at) {
  int32_t bits;
  std::memcpy(&bits, at, sizeof bits);
  return hn::Set(d, bits);
}

// Rounded, 0 to 255.
HWY_INLINE void StoreBytes(F d, VF numbers, uint8_t* out) {
#if HWY_TARGET == HWY_AVX3_DL
  // DemoteTo is three instructions; TruncateTo, of Highway 1.0.3, is wrong.
  alignas(16) static constexpr uint8_t kLowBytes[16] = {0,  4,  8,  12, 16, 20, 24, 28,
                                                        32, 36, 40, 44, 48, 52, 56, 60};
  const VF in_range = hn::Min(hn::Max(numbers, hn::Zero(d)), hn::Set(d, 255.f));
  const auto bytes = hn::NearestInt(in_range);
  const auto order = hn::LoadDup128(hn::Repartition<uint8_t, F>(), kLowBytes);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(out),
                   _mm512_castsi512_si128(_mm512_permutexvar_epi8(order.raw, bytes.raw)));
#else
  const hn::Rebind<uint8_t, F> bytes;
  (void)d;
  hn::StoreU(hn::DemoteTo(bytes, hn::NearestInt(numbers)), bytes, out);
#endif
}

template <size_t kVectors, size_t kPixels>
HWY_ATTR void Block(const ConvolveByteRow& row, size_t x, size_t channel) {
  const I d;
  const F df;
  const size_t lanes = hn::Lanes(d), step = row.in_step, stride = 4 * padded(row.outputs);
  VI sum[kPixels][kVectors];
#pragma GCC unroll 16
  for (size_t p = 0; p < kPixels; ++p)
#pragma GCC unroll 4
    for (size_t v = 0; v < kVectors; ++v) sum[p][v] = hn::Zero(d);
  const int8_t* weights = row.weights + 4 * channel;
  for (size_t r = 0; r < row.height; ++r) {
    const uint8_t* in = row.rows[r] + x * step;
    for (size_t k = 0; k < row.quads; ++k, in += 4, weights += stride) {
      VI weight[kVectors];
#pragma GCC unroll 4
      for (size_t v = 0; v < kVectors; ++v)
        weight[v] = hn::LoadU(d, reinterpret_cast<const int32_t*>(weights) + v * lanes);
#pragma GCC unroll 16
      for (size_t p = 0; p < kPixels; ++p) {
        const VI value = Quad(d, in + p * step);
#pragma GCC unroll 4
        for (size_t v = 0; v < kVectors; ++v)
          sum[p][v] = MultiplyQuads(d, value, weight[v], sum[p][v]);
      }
    }
  }
  const VF zero = hn::Zero(df), offset = hn::Set(df, row.zero);
#pragma GCC unroll 16
  for (size_t p = 0; p < kPixels; ++p) {
    const size_t at = (x + p) * padded(row.outputs) + channel;
#pragma GCC unroll 4
    for (size_t v = 0; v < kVectors; ++v) {
      const size_t c = channel + v * lanes;
      const VF linear = hn::MulAdd(hn::ConvertTo(df, sum[p][v]), hn::LoadU(df, row.scale + c),
                                   hn::LoadU(df, row.bias + c));
      const VF y =
          hn::MulAdd(hn::LoadU(df, row.slope + c), hn::Min(linear, zero), hn::Max(linear, zero));
      if (row.numbers) {
        hn::StoreU(y, df, row.numbers + at + v * lanes);
      } else {
        StoreBytes(df, hn::Add(y, offset), row.bytes + at + v * lanes);
      }
    }
  }
}

using BlockFunction = void (*)(const ConvolveByteRow&, size_t, size_t);
template <size_t kVectors, size_t... kPixels>
constexpr std::array<BlockFunction, sizeof...(kPixels)> blocks(std::index_sequence<kPixels...>) {
  return {&Block<kVectors, kPixels + 1>...};
}

template <size_t kVectors>
void Row(const ConvolveByteRow& row) {
  constexpr size_t kMost = kMostPixels[kVectors];
  static constexpr auto kBlocks = blocks<kVectors>(std::make_index_sequence<kMost>());
  const size_t step = kVectors * hn::Lanes(I()), end = padded(row.outputs);
  size_t left = (row.pixels + kMost - 1) / kMost;  // blocks of about the same size
  for (size_t x = 0; x < row.pixels; --left) {
    const size_t count = (row.pixels - x + left - 1) / left;
    for (size_t channel = 0; channel < end; channel += step) kBlocks[count - 1](row, x, channel);
    x += count;
  }
}

void Convolve(const ConvolveByteRow& row) {
  const size_t vectors = padded(row.outputs) / hn::Lanes(I());
  if (vectors % 2 == 0) return Row<2>(row);
  return vectors % 3 == 0 ? Row<3>(row) : Row<1>(row);
}

void Pool(const PoolByteRow& row) {
  const hn::CappedTag<uint8_t, kGroup> d;
  const size_t lanes = hn::Lanes(d), channels = row.channels;
  // Upwards, for what a vector has too many is the next pixel's.
  for (size_t x = 0; x < row.out_pixels; ++x) {
    const size_t first = 2 * x * row.in_step;
    const size_t columns = std::min(row.width, row.in_pixels - 2 * x);
    for (size_t c = 0; c < channels; c += lanes) {
      auto most = hn::LoadU(d, row.rows[0] + first + c);
      for (size_t r = 0; r < row.height; ++r)
        for (size_t column = 0; column < columns; ++column)
          most = hn::Max(most, hn::LoadU(d, row.rows[r] + first + column * row.in_step + c));
      hn::StoreU(most, d, row.out + x * row.out_step + c);
    }
  }
}

}  // namespace mtcnn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mtcnn::kernels {

HWY_EXPORT(Convolve);
HWY_EXPORT(Pool);

void convolve(const ConvolveByteRow& row) {
  HWY_DYNAMIC_DISPATCH(Convolve)(row);
}
void pool(const PoolByteRow& row) {
  HWY_DYNAMIC_DISPATCH(Pool)(row);
}

}  // namespace mtcnn::kernels
#endif
