// The loops that finish one row of a tensor, compiled for each vector extension of the CPU.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/preprocess/preparation.hpp"

namespace weir::preprocess {

// Rows of floats are readable and writable up to a multiple of this many elements; the elements
// after the row have any value.
inline constexpr size_t kRowBlock = 64;
constexpr size_t padded(size_t elements) noexcept {
  return (elements + kRowBlock - 1) / kRowBlock * kRowBlock;
}

// Computes the colors of the target's channels from the samples of a pixel: 3 of 3, 1 of 3 or 1 of
// 1. Channel r is the sum over s of of[r][s] * sample s + add[r], clamped to 0..255; if `computed`
// is false it is sample r.
struct ColorTransform {
  size_t samples = 3, channels = 3;
  bool computed = false;
  float of[3][3] = {};
  float add[3] = {};
};

// number = (pixel - mean) * scale; integers: number / divisor + zero_point, rounded.
struct NumberRule {
  float mean = 0, scale = 1, divisor = 1;
  int32_t zero_point = 0;
};

// Channel c goes to rows[c]; with `together`, all go to rows[0] as a0 b0 c0 a1 b1 c1 ...
struct FloatTarget {
  float* rows[3] = {};
  bool together = false;
  bool padded = false;  // rows are as long as padded(count) and may be overwritten to the end
};
// Writes `count` float32 numbers per channel by rules[c], at any alignment of floats. `in` has a
// row for each of transform.samples. Padded target rows may also be sources; in other rows the last
// vector may overlap the one before it.
void finish_row(const float* const* in, const ColorTransform& transform, const NumberRule* rules,
                const FloatTarget& to, size_t count) noexcept;

// Writes `count` elements of `type` (one that check_target() accepts), at any alignment.
void write_numbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                   void* out) noexcept;

// out = a0 b0 c0 a1 b1 c1 ..., at any alignment; elements of 1, 2 or 4 bytes.
void interleave_three(const void* const* rows, size_t element_bytes, size_t count,
                      void* out) noexcept;

}  // namespace weir::preprocess
