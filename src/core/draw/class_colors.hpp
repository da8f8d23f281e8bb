// Paints maps of classes and gray levels as RGBA pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/draw/rgba_frame.hpp"

namespace weir::draw {

// Class 0, the background, is transparent. Class i of the others is opaque; its blue, green and red
// bytes together are i times the largest number that keeps the last class within 0xFFFFFF, so that
// colours are spread over all and the same in every process. `classes` includes class 0.
std::vector<Rgba> spread_colors(size_t classes);

// Precondition: `pixels` has as many elements as `map`, and each element of `map` has a colour.
void paint_classes(std::span<const uint16_t> map, std::span<const Rgba> colors,
                   std::span<Rgba> pixels) noexcept;
// Opaque gray pixels, as many as `grays`.
void paint_grays(std::span<const uint8_t> grays, std::span<Rgba> pixels) noexcept;

}  // namespace weir::draw
