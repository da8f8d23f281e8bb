// RgbaFrame: draws lines, rectangles and text into a frame of 4-byte RGBA pixels. Used by decoders
// whose output is a transparent frame to blend over the picture.
//
//   draw::RgbaFrame frame(bytes, 640, 480);
//   frame.clear();
//   frame.outline(10, 20, 110, 220, draw::kRed);
//   frame.text(10, 6, "person", draw::kRed);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>
#include "core/tensor/geometry.hpp"

namespace weir::draw {

// A pixel's bytes in memory order.
struct Rgba {
  uint8_t red = 0, green = 0, blue = 0, alpha = 0;
  bool operator==(const Rgba&) const = default;
};
static_assert(sizeof(Rgba) == 4 && alignof(Rgba) == 1);

inline constexpr Rgba kTransparent{}, kRed{255, 0, 0, 255}, kWhite{255, 255, 255, 255};

inline size_t rgba_bytes(Size size) noexcept {
  return sizeof(Rgba) * size.width * size.height;
}

// Every function clips at the edges of the frame, and its cost depends on the pixels in the frame
// only: coordinates may be anything.
class RgbaFrame {
 public:
  // Borrows `bytes`. Precondition: they are rgba_bytes(size) long and aligned to 4.
  RgbaFrame(std::span<std::byte> bytes, Size size) noexcept
      : pixels_(reinterpret_cast<uint32_t*>(bytes.data())),
        width_(size.width),
        height_(size.height) {}

  // Makes every pixel transparent black.
  void clear() noexcept;
  void set(int64_t x, int64_t y, Rgba color) noexcept {
    if (x >= 0 && y >= 0 && x < width_ && y < height_)
      pixels_[y * width_ + x] = std::bit_cast<uint32_t>(color);
  }
  // A rectangle of 1 pixel: the rows `top` and `bottom` from left to right and the columns `left`
  // and `right` between these rows.
  void outline(int64_t left, int64_t top, int64_t right, int64_t bottom, Rgba color) noexcept;
  // Bresenham's line with both ends. `thickness` 2 also sets the pixels to the right of and below
  // each pixel of the line.
  void line(int64_t x1, int64_t y1, int64_t x2, int64_t y2, Rgba color, int thickness = 1) noexcept;
  // Text whose first cell has its top left pixel at (x, y). Writes cells completely: pixels of a
  // cell that are outside the glyph become transparent. Stops at the first cell that does not fit
  // into the width.
  void text(int64_t x, int64_t y, std::string_view text, Rgba color) noexcept;

 private:
  uint32_t* pixels_;  // written whole, which bytes are not
  int64_t width_, height_;
};

// Cells advance by one pixel more than their width.
inline constexpr int kGlyphAdvance = 9;

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
