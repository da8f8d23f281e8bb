// The loops over one row, for whatever vectors the CPU has.
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

// Rows of float are readable and writable up to a multiple of this many elements, and what lies
// behind the row may hold anything.
inline constexpr size_t kRowBlock = 64;
constexpr size_t padded(size_t elements) noexcept {
  return (elements + kRowBlock - 1) / kRowBlock * kRowBlock;
}

// out[i] = sum over k of weights[k] * rows[k][i], for exactly `bytes` elements.
void blend_rows(const uint8_t* const* rows, const float* weights, size_t taps, size_t bytes,
                float* out) noexcept;

// out[i] = sum over k of weights[k * stride + i] * in[index[k * stride + i]], stride being
// padded(count). With one tap the weights are not read: they are 1.
void gather_row(const float* in, const int32_t* index, const float* weights, size_t taps,
                size_t count, float* out) noexcept;

// Three rows and what each of them becomes: out[r] = sum over c of of[r][c] * in[c] + add[r],
// limited to 0..255. In place.
struct ColorTransform {
  float of[3][3];
  float add[3];
};
void transform_colors(const ColorTransform& transform, float* const* rows, size_t count) noexcept;
// The same for one row: row = row * factor + add, limited to 0..255.
void transform_gray(float factor, float add, float* row, size_t count) noexcept;
// The first row becomes of[0] * a + of[1] * b + of[2] * c.
void mix_to_gray(const float* of, float* const* rows, size_t count) noexcept;

// number = (pixel - mean) * scale; for integers number / divisor + zero_point, rounded.
struct NumberRule {
  float mean = 0, scale = 1, divisor = 1;
  int32_t zero_point = 0;
};
// Writes `count` elements of `type` (one that check_target() lets through), at any alignment.
// streamed: past the caches where the type allows; end_streaming() before another thread reads.
void write_numbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                   void* out, bool streamed = false) noexcept;
void end_streaming() noexcept;

// out = a0 b0 c0 a1 b1 c1 ..., at any alignment; elements of 1, 2 or 4 bytes.
void interleave_three(const void* const* rows, size_t element_bytes, size_t count,
                      void* out) noexcept;

}  // namespace weir::preprocess
