// Blends pairs with AVX-512 VBMI, with the same arithmetic as pair_kernels.cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/wide_windows.hpp"

#include <hwy/highway.h>

#include <cstdlib>

#include "core/transform/avx512_bytes.hpp"

#if WEIR_AVX512_BYTES
#include <immintrin.h>
#define WEIR_WITH_AVX512_BYTES __attribute__((target("avx512f,avx512bw,avx512vbmi")))
#endif

namespace weir::preprocess {

#if WEIR_AVX512_BYTES

bool has_wide_windows() noexcept {
  return (hwy::SupportedTargets() & HWY_AVX3) != 0 && transform::has_avx512_bytes();
}

namespace {

// The bytes at `places` of `vectors` vectors. `beyond` masks the places past the first two vectors.
template <size_t vectors>
WEIR_WITH_AVX512_BYTES __m512i look_up(const __m512i* in, __m512i places, __mmask64 beyond) {
  if constexpr (vectors == 1)  // without a mask, GCC 12 warns
    return _mm512_maskz_permutexvar_epi8(~__mmask64{0}, places, in[0]);
  const __m512i near = _mm512_permutex2var_epi8(in[0], places, in[1]);
  if constexpr (vectors == 3) return _mm512_mask_permutexvar_epi8(near, beyond, places, in[2]);
  if constexpr (vectors == 4)
    return _mm512_mask_mov_epi8(near, beyond, _mm512_permutex2var_epi8(in[2], places, in[3]));
  return near;
}

template <size_t vectors, bool two_rows>
WEIR_WITH_AVX512_BYTES void blend(const SourceRows& from, const PairColumns& columns,
                                  int16_t row_share, int16_t* out) noexcept {
  const __m512i down = _mm512_set1_epi16(row_share);
  const uint8_t* const rows[2] = {from.rows[0], from.rows[two_rows]};
  const uint8_t* const next[2] = {from.next[0], from.next[two_rows]};
  const size_t lanes = columns.wide_lanes;
  const auto made = static_cast<__mmask32>((uint64_t{1} << lanes) - 1);
  const __m512i low_bytes = _mm512_set1_epi16(0xFF);
  const uint32_t* const windows = columns.windows[0].data();
  const uint8_t* const lookup = columns.lookup[0][0].data();
  const int16_t* const shares = columns.shares.data();
  for (size_t w = 0, count = columns.windows[0].size(); w < count; ++w) {
    const __m512i places = _mm512_loadu_si512(lookup + w * kWideBytes);
    const __mmask64 beyond = vectors > 2 ? _mm512_movepi8_mask(places) : 0;
    const __m512i share = _mm512_loadu_si512(shares + w * lanes);
    for (size_t v = 0; v < vectors; ++v)
      for (size_t r = 0; r <= two_rows; ++r)
        __builtin_prefetch(next[r] + windows[w] + v * kWideBytes);
    const auto row = [&](const uint8_t* bytes) WEIR_WITH_AVX512_BYTES {
      __m512i in[vectors];
      for (size_t v = 0; v < vectors; ++v)
        in[v] = _mm512_loadu_si512(bytes + windows[w] + v * kWideBytes);
      const __m512i both = look_up<vectors>(in, places, beyond);
      const __m512i a = _mm512_and_si512(both, low_bytes), b = _mm512_srli_epi16(both, 8);
      const __m512i difference = _mm512_slli_epi16(_mm512_sub_epi16(a, b), 7);
      return _mm512_add_epi16(_mm512_slli_epi16(a, 7), _mm512_mulhrs_epi16(difference, share));
    };
    __m512i value = row(rows[0]);
    if constexpr (two_rows)
      value =
          _mm512_add_epi16(value, _mm512_mulhrs_epi16(_mm512_sub_epi16(value, row(rows[1])), down));
    _mm512_mask_storeu_epi16(out + w * lanes, made, value);
  }
}

}  // namespace

void blend_wide_windows(const SourceRows& from, const PairColumns& columns, int16_t row_share,
                        int16_t* out) noexcept {
  using Blend = void (*)(const SourceRows&, const PairColumns&, int16_t, int16_t*) noexcept;
  constexpr Blend kBlends[kWideVectors][2] = {{blend<1, false>, blend<1, true>},
                                              {blend<2, false>, blend<2, true>},
                                              {blend<3, false>, blend<3, true>},
                                              {blend<4, false>, blend<4, true>}};
  kBlends[columns.wide - 1][from.count - 1](from, columns, row_share, out);
}

#else

bool has_wide_windows() noexcept {
  return false;
}
void blend_wide_windows(const SourceRows&, const PairColumns&, int16_t, int16_t*) noexcept {
  std::abort();  // unreachable: no columns are wide
}

#endif

}  // namespace weir::preprocess
