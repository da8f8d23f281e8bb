// Finds the lines of text in a map of probabilities, as "Real-time Scene Text Detection with
// Differentiable Binarization" (Liao et al., 2020) and PP-OCR describe it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace weir::detection {

struct TextRegionOptions {
  float min_pixel = 0.3f;  // probability of a pixel of text
  float min_score = 0.6f;  // mean probability in a box
  float unclip = 1.5f;     // a box grows on each side by this part of area / perimeter
};

// A box about its centre, in pixels of the map. The width is the direction of reading: boxes at
// least 1.5 times as high as wide are read from top to bottom.
struct TextRegion {
  float x = 0, y = 0, width = 0, height = 0;
  float angle = 0;  // of the width, clockwise, in radians: -pi / 4 to 3 / 4 pi
  float score = 0;
};

// The smallest rotated boxes around connected pixels of text, in the order of their first pixels.
// Boxes of less than 3 pixels are left out. NaN counts as 0. Precondition: width * height values.
std::vector<TextRegion> find_text_regions(std::span<const float> map, size_t width, size_t height,
                                          const TextRegionOptions& options);

}  // namespace weir::detection
