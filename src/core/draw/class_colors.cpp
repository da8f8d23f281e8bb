// Looks up colours of classes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/class_colors.hpp"

#include <algorithm>

namespace weir::draw {

std::vector<Rgba> spread_colors(size_t classes) {
  std::vector<Rgba> colors(classes);
  const uint64_t step = 0xFFFFFF / std::max<size_t>(classes, 1);
  for (size_t i = 1; i < classes; ++i) {
    const uint64_t color = step * i;
    colors[i] = {static_cast<uint8_t>(color), static_cast<uint8_t>(color >> 8),
                 static_cast<uint8_t>(color >> 16), 255};
  }
  return colors;
}

void paint_classes(std::span<const uint16_t> map, std::span<const Rgba> colors,
                   std::span<Rgba> pixels) noexcept {
  for (size_t i = 0; i < map.size(); ++i) pixels[i] = colors[map[i]];
}

void paint_grays(std::span<const uint8_t> grays, std::span<Rgba> pixels) noexcept {
  for (size_t i = 0; i < grays.size(); ++i) pixels[i] = {grays[i], grays[i], grays[i], 255};
}

}  // namespace weir::draw
