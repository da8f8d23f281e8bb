// 8-bit kernels: one source, compiled once per CPU target for its vector width.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "byte_kernels.hpp"

#include <cstring>

// Vectors are kept in arrays, which is impossible for scalable vectors.
#undef HWY_DISABLED_TARGETS  // of a sanitizer build
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#define HWY_WANT_AVX3_DL  // has VNNI
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "byte_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace mtcnn::kernels::HWY_NAMESPACE {

using I = hn::CappedTag<int32_t, kGroup>;
using F = hn::RebindToFloat<I>;
using VI = hn::Vec<I>;
using VF = hn::Vec<F>;

// Returns sum + a[0] * b[0] + ... + a[3] * b[3] per lane: unsigned bytes of `a`, signed bytes of
// `b`.
HWY_INLINE VI MultiplyQuads(I d, VI a, VI b, VI sum) {
#if HWY_TARGET == HWY_AVX3_DL
  (void)d;  // Highway 1.0.3 does not enable this instruction set in the compiler
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

// Rounds and clamps to 0..255.
HWY_INLINE void StoreBytes(F d, VF numbers, uint8_t* out) {
#if HWY_TARGET == HWY_AVX3_DL
  // DemoteTo takes three instructions; TruncateTo of Highway 1.0.3 is wrong.
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

struct ByteBlocks {
  using Row = ConvolveByteRow;
// The sums of kPixels pixels times kVectors vectors of channels stay in registers.
#if HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM
  static constexpr size_t kMaxPixels[] = {0, 12, 12, 8};
#else
  static constexpr size_t kMaxPixels[] = {0, 8, 4, 2};
#endif
  static size_t lanes() {
    return hn::Lanes(I());
  }

  // NOLINTBEGIN(readability-function-cognitive-complexity): the sums stay in registers from the
  // first loop to the last one
  template <size_t kVectors, size_t kPixels>
  static HWY_ATTR void block(const Row& row, size_t x, size_t channel) {
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
  // NOLINTEND(readability-function-cognitive-complexity)
};

void Convolve(const ConvolveByteRow& row) {
  const size_t vectors = padded(row.outputs) / hn::Lanes(I());
  if (vectors % 2 == 0) return in_blocks<ByteBlocks, 2>(row);
  return vectors % 3 == 0 ? in_blocks<ByteBlocks, 3>(row) : in_blocks<ByteBlocks, 1>(row);
}

void PoolBytes(const PoolRow<uint8_t>& row) {
  Pool(row);
}

}  // namespace mtcnn::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mtcnn::kernels {

HWY_EXPORT(Convolve);
HWY_EXPORT(PoolBytes);

void convolve(const ConvolveByteRow& row) {
  HWY_DYNAMIC_DISPATCH(Convolve)(row);
}
void pool(const PoolRow<uint8_t>& row) {
  HWY_DYNAMIC_DISPATCH(PoolBytes)(row);
}

}  // namespace mtcnn::kernels
#endif
