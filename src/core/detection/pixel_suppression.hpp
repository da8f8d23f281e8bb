// Non-maximum suppression of boxes in whole pixels, as the mode bounding_boxes defines it. It
// differs from weir::suppress: an intersection includes the pixel at its right and lower edge, and
// areas do not.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/detection/pixel_box.hpp"

namespace weir::detection {

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
