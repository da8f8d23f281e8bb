// Class colours, and colours as samples of a picture format.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>

#include "core/preprocess/preparation.hpp"

namespace weir::draw {

struct Rgb {
  uint8_t red = 0, green = 0, blue = 0;
  bool operator==(const Rgb&) const = default;
};

// A bright colour whose hue differs clearly from those of adjacent classes: hues advance by the
// golden ratio.
Rgb class_color(uint64_t class_index) noexcept;
// From dark violet (0) over green to yellow (255), each level brighter than the one before it.
Rgb depth_color(uint32_t level) noexcept;
// Black or white, whichever is easier to read on `ground`.
Rgb text_color(Rgb ground) noexcept;

// One sample for each component of the format: R'G'B', Y'CbCr by the picture's matrix and range, or
// gray (0.299 R' + 0.587 G' + 0.114 B') in the picture's range. Rounded to the nearest integer.
std::array<uint8_t, 3> to_samples(const preprocess::Picture& picture, Rgb color) noexcept;

// The bytes of a pixel in each plane, repeated. Samples of a plane are 1, 2, 3 or 4 bytes apart,
// and 48 is a multiple of these. Three vectors of up to 64 bytes are whole periods. Bytes outside
// all components (alpha, padding) are 255.
inline constexpr size_t kPatternPeriod = 48, kPatternBytes = 192;
using Pattern = std::array<uint8_t, kPatternBytes>;
struct Paint {
  std::array<Pattern, 3> planes;
};
Paint make_paint(const preprocess::Picture& picture, Rgb color) noexcept;

}  // namespace weir::draw
