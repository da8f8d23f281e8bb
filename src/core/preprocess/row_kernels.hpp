// The loops over one row, for whatever vectors the CPU has.
// SPDX-License-Identifier: LGPL-2.1-or-later
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

// What samples of 16 bits are multiplied by.
inline constexpr size_t kSampleScale = 128;

// The samples of one kind in a row: `floats`, or lane `offset` of the `lanes` (1, 2 or 4) that each
// pixel has in `samples`, which are kSampleScale times the value. Readable up to padded(count)
// pixels.
struct LaneRow {
  const float* floats = nullptr;
  const int16_t* samples = nullptr;
  size_t lanes = 1, offset = 0;

  // What one of the numbers in the row is of a sample.
  float unit() const noexcept { return floats ? 1.0f : 1.0f / kSampleScale; }
};

// What the samples of a pixel are as the colors of the target's channels: 3 of 3, 1 of 3, 1 of 1.
// Channel r is the sum over s of of[r][s] * sample s + add[r], limited to 0..255; where nothing is
// computed it is sample r.
struct ColorTransform {
  size_t samples = 3, channels = 3;
  bool computed = false;
  float of[3][3] = {};
  float add[3] = {};
};

// number = (pixel - mean) * scale; for integers number / divisor + zero_point, rounded.
struct NumberRule {
  float mean = 0, scale = 1, divisor = 1;
  int32_t zero_point = 0;
};

// Where the numbers of channel c go, rows[c]; together: all to rows[0], a0 b0 c0 a1 b1 c1 ...
struct FloatTarget {
  float* rows[3] = {};
  bool together = false;
  bool padded = false;  // rows as long as padded(count): what lies behind their numbers is free
};
// Writes `count` numbers a channel, by rules[c], at any alignment of floats, as they would be
// written as float32. `transform.of` is for the numbers as they lie in their rows: what it is for
// samples, times their unit(). Has as many sources as the transform has samples. Padded rows may be
// sources; of others the last vector may be made twice.
void finish_row(const LaneRow* in, const ColorTransform& transform, const NumberRule* rules,
                const FloatTarget& to, size_t count) noexcept;

// Writes `count` elements of `type` (one that check_target() lets through), at any alignment.
void write_numbers(const NumberRule& rule, ElementType type, const float* row, size_t count,
                   void* out) noexcept;

// out = a0 b0 c0 a1 b1 c1 ..., at any alignment; elements of 1, 2 or 4 bytes.
void interleave_three(const void* const* rows, size_t element_bytes, size_t count,
                      void* out) noexcept;

}  // namespace weir::preprocess
