// Reads the outputs of segmentation and depth networks: a class or a gray level for each pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace weir::detection {

// All functions work pixel by pixel, so that a caller may pass a picture in parts, except for
// classes_from_planes and max_depth, which need all of it.

// The class of each pixel is that of its greatest score if this is above `threshold`, otherwise 0.
// `scores` holds `classes` numbers for each element of `out`. The first of equal scores wins;
// not-a-number never does.
void classes_from_scores(std::span<const float> scores, size_t classes, float threshold,
                         std::span<uint16_t> out) noexcept;

// The same for scores that are one plane for each class, without a threshold: the class of the
// greatest score, the first of equal ones; 0 where no score is a number.
void classes_from_planes(std::span<const float> scores, size_t classes, std::span<uint16_t> out);

// Converts class numbers to integers, rounding toward zero. Returns the index of the first value
// that is not from 0 to `classes` - 1; the contents of `out` are then undefined. `out` has as many
// elements as `numbers`, and `classes` is at most 65536.
std::optional<size_t> classes_from_numbers(std::span<const float> numbers, size_t classes,
                                           std::span<uint16_t> out) noexcept;

struct MaxDepth {
  float value = 0;                     // 0 if no value is above 0
  std::optional<size_t> not_finite{};  // the index of the first value that is NaN or infinite
};
MaxDepth max_depth(std::span<const float> depths) noexcept;

// Scales depths from 0 to `max`, which is above 0, to 0 to 255, rounding down. Depths below 0
// become 0.
void grays_from_depths(std::span<const float> depths, float max, std::span<uint8_t> out) noexcept;

}  // namespace weir::detection
