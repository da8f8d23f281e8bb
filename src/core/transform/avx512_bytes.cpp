// AVX-512 VBMI and VNNI kernels for bytes: sums of squares, and three-byte pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/avx512_bytes.hpp"

#include <atomic>

#if WEIR_AVX512_BYTES
#include <immintrin.h>
#define WEIR_WITH_AVX512_BYTES \
  __attribute__((target("avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vnni")))
#endif

namespace weir::transform {
namespace {

std::atomic<bool> allowed_here{true};

}  // namespace

void allow_avx512_bytes(bool allowed) noexcept {
  allowed_here.store(allowed, std::memory_order_relaxed);
}

#if WEIR_AVX512_BYTES

bool has_avx512_bytes() noexcept {
  static const bool has = __builtin_cpu_supports("avx512vbmi") != 0 &&
                          __builtin_cpu_supports("avx512vnni") != 0 &&
                          __builtin_cpu_supports("avx512bw") != 0;
  return has && allowed_here.load(std::memory_order_relaxed);
}

WEIR_WITH_AVX512_BYTES static int64_t sum_of_lanes(__m512i vector) noexcept {
  alignas(64) int32_t lanes[16];
  _mm512_store_si512(lanes, vector);
  int64_t sum = 0;
  for (const int32_t lane : lanes) sum += lane;
  return sum;
}

// x^2 = x (x - 128) + 128 x: x is unsigned and x - 128 signed, as the instruction requires.
WEIR_WITH_AVX512_BYTES ByteSums add_bytes_avx512(const uint8_t* in, size_t count,
                                                 uint8_t turned) noexcept {
  constexpr size_t kLanes = 64, kChains = 4;
  constexpr size_t kVectors = 8192;  // times 4 * 255 * 127 fit into a lane of 31 bits
  const __m512i one = _mm512_set1_epi8(1), half = _mm512_set1_epi8(static_cast<char>(0x80)),
                turn = _mm512_set1_epi8(static_cast<char>(turned));
  int64_t sum = 0, products = 0;
  for (size_t i = 0, whole = count / kLanes; i < whole;) {
    __m512i sums[kChains], more[kChains];
    for (size_t k = 0; k < kChains; ++k) sums[k] = more[k] = _mm512_setzero_si512();
    const auto add = [&](size_t k, size_t at) WEIR_WITH_AVX512_BYTES {
      const __m512i x = _mm512_xor_si512(_mm512_loadu_si512(in + at * kLanes), turn);
      sums[k] = _mm512_dpbusd_epi32(sums[k], x, one);
      more[k] = _mm512_dpbusd_epi32(more[k], x, _mm512_xor_si512(x, half));
    };
    const size_t end = whole - i < kVectors ? whole : i + kVectors;
    for (; i + kChains <= end; i += kChains) {
      add(0, i);
      add(1, i + 1);
      add(2, i + 2);
      add(3, i + 3);
    }
    for (; i < end; ++i) add(0, i);
    for (size_t k = 0; k < kChains; ++k) {
      sum += sum_of_lanes(sums[k]);
      products += sum_of_lanes(more[k]);
    }
  }
  return {static_cast<uint64_t>(sum), static_cast<uint64_t>(products + 128 * sum)};
}

namespace {

// Indices that combine four rows of four pixels from two sources to columns 2 p and 2 p + 1 of
// eight rows, 24 bytes each, and two of these to column p of sixteen rows.
struct TripleIndices {
  alignas(64) uint8_t eight[2][64] = {};
  alignas(64) uint8_t sixteen[2][64] = {};
};
constexpr TripleIndices triple_indices() {
  constexpr size_t kEight = 24;  // bytes of eight pixels
  TripleIndices indices;
  for (size_t p = 0; p < 2; ++p) {
    for (size_t i = 0; i < 2 * kEight; ++i) {
      const size_t column = 2 * p + i / kEight, row = i % kEight / 3;
      indices.eight[p][i] = static_cast<uint8_t>(row / 4 * 64 + row % 4 * 16 + column * 3 + i % 3);
      indices.sixteen[p][i] = static_cast<uint8_t>(i / kEight * 64 + p * kEight + i % kEight);
    }
  }
  return indices;
}
constexpr TripleIndices kTripleIndices = triple_indices();

WEIR_WITH_AVX512_BYTES inline __m512i load_four_rows(const uint8_t* in, size_t stride) noexcept {
  const auto row = [&](size_t r) WEIR_WITH_AVX512_BYTES {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(in + r * stride));
  };
  __m512i rows = _mm512_castsi128_si512(row(0));
  rows = _mm512_mask_broadcast_i32x4(rows, 0x00F0, row(1));
  rows = _mm512_mask_broadcast_i32x4(rows, 0x0F00, row(2));
  return _mm512_mask_broadcast_i32x4(rows, 0xF000, row(3));
}

}  // namespace

WEIR_WITH_AVX512_BYTES void move_triples_avx512(const uint8_t* in, size_t in_stride, uint8_t* out,
                                                size_t out_stride, size_t tiles) noexcept {
  constexpr __mmask8 k48Bytes = 0x3F;
  const __m512i low = _mm512_load_si512(kTripleIndices.eight[0]),
                high = _mm512_load_si512(kTripleIndices.eight[1]),
                even = _mm512_load_si512(kTripleIndices.sixteen[0]),
                odd = _mm512_load_si512(kTripleIndices.sixteen[1]);
  for (size_t tile = 0; tile < tiles; ++tile) {
    const __m512i a = load_four_rows(in, in_stride),
                  b = load_four_rows(in + 4 * in_stride, in_stride),
                  c = load_four_rows(in + 8 * in_stride, in_stride),
                  e = load_four_rows(in + 12 * in_stride, in_stride);
    const __m512i low_ab = _mm512_permutex2var_epi8(a, low, b),
                  low_ce = _mm512_permutex2var_epi8(c, low, e),
                  high_ab = _mm512_permutex2var_epi8(a, high, b),
                  high_ce = _mm512_permutex2var_epi8(c, high, e);
    const auto store = [&](size_t column, __m512i x) WEIR_WITH_AVX512_BYTES {
      _mm512_mask_storeu_epi64(out + column * out_stride, k48Bytes, x);
    };
    store(0, _mm512_permutex2var_epi8(low_ab, even, low_ce));
    store(1, _mm512_permutex2var_epi8(low_ab, odd, low_ce));
    store(2, _mm512_permutex2var_epi8(high_ab, even, high_ce));
    store(3, _mm512_permutex2var_epi8(high_ab, odd, high_ce));
    in += kTripleColumns * 3;
    out += kTripleColumns * out_stride;
  }
}

#else

bool has_avx512_bytes() noexcept {
  return false;
}
ByteSums add_bytes_avx512(const uint8_t*, size_t, uint8_t) noexcept {
  return {};
}
void move_triples_avx512(const uint8_t*, size_t, uint8_t*, size_t, size_t) noexcept {}

#endif

}  // namespace weir::transform
