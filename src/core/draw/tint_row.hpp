// Mixes a colour into a row of bytes, with the vectors of the CPU.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "core/draw/color.hpp"

namespace weir::draw {

// (d * (255 - a) + p * a) / 255, rounded to the nearest integer.
inline uint8_t mixed(uint8_t d, uint8_t p, uint8_t a) noexcept {
  const auto sum = static_cast<uint16_t>(d * (255 - a) + p * a + 128);
  return static_cast<uint8_t>((sum + (sum >> 8)) >> 8);
}

// Mixes `opacity` / 255 of the pattern into each byte; the pattern begins at the first one.
void tint_row(std::byte* row, uint8_t opacity, size_t bytes, const Pattern& pattern) noexcept;

}  // namespace weir::draw
