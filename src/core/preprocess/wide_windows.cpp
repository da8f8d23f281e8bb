// The same arithmetic as in pair_kernels.cpp.
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

template <bool two_vectors, bool two_rows>
WEIR_WITH_AVX512_BYTES void blend(const uint8_t* const* rows, const PairColumns& columns,
                                  int16_t row_share, int16_t* out) noexcept {
  constexpr __mmask64 kLowBytes = 0x5555555555555555;  // of each lane of 16 bits
  const __m512i to_second = _mm512_set1_epi8(static_cast<char>(columns.step));
  const __m512i down = _mm512_set1_epi16(row_share);
  const uint32_t* const windows = columns.windows[0].data();
  const uint8_t* const lookup = columns.lookup[0][0].data();
  const int16_t* const shares = columns.shares.data();
  for (size_t w = 0, count = columns.windows[0].size(); w < count; ++w) {
    const __m512i first = _mm512_loadu_si512(lookup + w * kWideBytes);
    const __m512i second = _mm512_add_epi8(first, to_second);
    const __m512i share = _mm512_loadu_si512(shares + w * kWideLanes);
    const auto row = [&](const uint8_t* from) WEIR_WITH_AVX512_BYTES {
      const __m512i low = _mm512_loadu_si512(from + windows[w]);
      __m512i a, b;
      if constexpr (two_vectors) {
        const __m512i high = _mm512_loadu_si512(from + windows[w] + kWideBytes);
        a = _mm512_maskz_permutex2var_epi8(kLowBytes, low, first, high);
        b = _mm512_maskz_permutex2var_epi8(kLowBytes, low, second, high);
      } else {
        a = _mm512_maskz_permutexvar_epi8(kLowBytes, first, low);
        b = _mm512_maskz_permutexvar_epi8(kLowBytes, second, low);
      }
      const __m512i difference = _mm512_slli_epi16(_mm512_sub_epi16(a, b), 7);
      return _mm512_add_epi16(_mm512_slli_epi16(a, 7), _mm512_mulhrs_epi16(difference, share));
    };
    __m512i value = row(rows[0]);
    if constexpr (two_rows)
      value =
          _mm512_add_epi16(value, _mm512_mulhrs_epi16(_mm512_sub_epi16(value, row(rows[1])), down));
    _mm512_storeu_si512(out + w * kWideLanes, value);
  }
}

}  // namespace

void blend_wide_windows(const uint8_t* const* rows, size_t row_count, const PairColumns& columns,
                        int16_t row_share, int16_t* out) noexcept {
  if (columns.wide == kWideBytes)
    row_count == 2 ? blend<false, true>(rows, columns, row_share, out)
                   : blend<false, false>(rows, columns, row_share, out);
  else
    row_count == 2 ? blend<true, true>(rows, columns, row_share, out)
                   : blend<true, false>(rows, columns, row_share, out);
}

#else

bool has_wide_windows() noexcept {
  return false;
}
void blend_wide_windows(const uint8_t* const*, size_t, const PairColumns&, int16_t,
                        int16_t*) noexcept {
  std::abort();  // no columns are wide
}

#endif

}  // namespace weir::preprocess
