// The bitmap font of decoders that draw text: cells of 8x13 pixels for ASCII 32 to 126.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace weir::draw {

inline constexpr int kGlyphWidth = 8, kGlyphHeight = 13;

// Rows from top to bottom; the most significant bit is the leftmost pixel.
using Glyph = std::array<uint8_t, kGlyphHeight>;

// The glyph of an ASCII character; '*' for every other byte.
const Glyph& get_glyph(char character) noexcept;

}  // namespace weir::draw
