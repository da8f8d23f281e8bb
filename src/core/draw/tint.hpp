// Tints the pixels of masks and class maps with a constant opacity.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "core/draw/canvas.hpp"

namespace weir::draw {

// Probabilities of 0 to 255, row after row, that cover an area of the picture.
struct AreaMask {
  uint32_t width = 0, height = 0;
  std::span<const uint8_t> values;  // width * height
};

// Tints the pixels of `area` where the mask, interpolated between the centres of its elements, is
// above 127: `opacity` / 255 of the colour. Works row by row on runs of pixels, so that the cost is
// that of the pixels tinted.
class MaskTinter {
 public:
  // Precondition: mask.values.size() == width * height, both above 0.
  void tint(const Area& area, const AreaMask& mask, uint8_t opacity, const Paint& paint,
            Canvas* canvas);

 private:
  void find_edges(const uint8_t* above, const uint8_t* below, uint32_t width);

  // Two rows of the mask:
  std::vector<uint8_t> inside_;  // how many of the two values are inside
  std::vector<uint32_t> edges_;  // elements between which and the next ones a run may begin or end
};

// Tints each pixel of `area` with the colour of its class: that of the nearest element of the map.
// `paint_of_class` returns null for classes that are not drawn.
void tint_classes(const Area& area, uint32_t width, uint32_t height,
                  std::span<const uint16_t> classes, uint8_t opacity,
                  const std::function<const Paint*(uint16_t)>& paint_of_class, Canvas* canvas);

}  // namespace weir::draw
