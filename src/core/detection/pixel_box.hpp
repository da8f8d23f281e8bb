// PixelBox: a detection in whole pixels of the model's input, as the mode bounding_boxes has it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/detection/candidate.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {

struct PixelBox {
  int32_t x = 0, y = 0, width = 0, height = 0;
  int32_t class_index = -1;
  float probability = 0;
  float angle = 0;  // radians; boxes with an angle have their centre at x, y
  bool operator==(const PixelBox&) const = default;
};
using PixelBoxes = std::vector<PixelBox>;

// Which values a scheme limits when it converts to pixels (docs/compatibility/decoder.md 5.3). The
// size does not change when the corner is moved into the picture.
enum class Limits {
  None,
  Corner,        // x and y are at least 0
  CornerAndSize  // and the box is not larger than the picture
};

// Truncates towards zero; values beyond 32 bits become the nearest that fits. Precondition: finite.
PixelBox to_pixels(const Candidate& candidate, Limits limits, Size picture) noexcept;
PixelBoxes to_pixels(std::span<const Candidate> candidates, Limits limits, Size picture);

// Intersection over union with an inclusive intersection; above 1 for equal boxes, 0 where the
// quotient is negative.
float inclusive_overlap(const PixelBox& a, const PixelBox& b) noexcept;
// The overlap of rotated boxes, from the 6 x 6 points of the smaller one that lie in the other.
float rotated_overlap(const PixelBox& a, const PixelBox& b) noexcept;

// Sorts by descending probability (equal ones keep their order) and removes the boxes that overlap
// a better one by more than `threshold`, of any class.
PixelBoxes suppress(PixelBoxes boxes, float threshold);
PixelBoxes suppress_rotated(PixelBoxes boxes, float threshold);

}  // namespace weir::detection
