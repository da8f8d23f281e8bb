// Draws into frames of RGBA pixels, clipped before the loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/rgba_frame.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "core/draw/glyphs.hpp"

namespace weir::draw {
namespace {

// Coordinates beyond this are drawn as if they were here: no frame is as large, and products of two
// of them fit into 64 bits.
constexpr int64_t kFar = int64_t{1} << 29;

// The bits of a glyph's row, from left to right; as wide as a pixel, so that a row is one vector
// operation.
constexpr std::array<uint32_t, kGlyphWidth> kColumnBits{0x80, 0x40, 0x20, 0x10, 8, 4, 2, 1};

int64_t bounded(int64_t at) {
  return std::clamp(at, -kFar, kFar);
}

std::array<uint32_t, kGlyphWidth> glyph_row(uint32_t bits, uint32_t paint) noexcept {
  std::array<uint32_t, kGlyphWidth> pixels;
  for (size_t column = 0; column < pixels.size(); ++column)
    pixels[column] = bits & kColumnBits[column] ? paint : 0;
  return pixels;
}

}  // namespace

void RgbaFrame::clear() noexcept {
  std::memset(pixels_, 0,
              sizeof(Rgba) * static_cast<size_t>(width_) * static_cast<size_t>(height_));
}

void RgbaFrame::outline(int64_t left, int64_t top, int64_t right, int64_t bottom,
                        Rgba color) noexcept {
  const auto paint = std::bit_cast<uint32_t>(color);
  const int64_t first = std::max<int64_t>(left, 0), end = std::min(right, width_ - 1) + 1;
  for (const int64_t y : {top, bottom})
    if (y >= 0 && y < height_ && first < end)
      std::fill(pixels_ + y * width_ + first, pixels_ + y * width_ + end, paint);
  const int64_t above = std::max<int64_t>(top, -1), below = std::min(bottom, height_);
  for (const int64_t x : {left, right})
    if (x >= 0 && x < width_)
      for (int64_t y = above + 1; y < below; ++y) pixels_[y * width_ + x] = paint;
}

// At step i of n along the longer axis, the other coordinate is the nearest to i * rise / n, where
// a half rounds away from the start. The steps that lie in the frame follow from the line's ends.
void RgbaFrame::line(int64_t x1, int64_t y1, int64_t x2, int64_t y2, Rgba color,
                     int thickness) noexcept {
  x1 = bounded(x1), y1 = bounded(y1), x2 = bounded(x2), y2 = bounded(y2);
  const bool is_steep = std::abs(y2 - y1) > std::abs(x2 - x1);
  if (is_steep) {
    std::swap(x1, y1);
    std::swap(x2, y2);
  }
  const int64_t start = x1, across = y1, run = x2 - x1, rise = y2 - y1;
  const int64_t steps = std::abs(run), direction = run < 0 ? -1 : 1;
  const int64_t side = rise < 0 ? -1 : 1, length = is_steep ? height_ : width_;
  // One pixel more, since a thick line reaches into the frame from the pixel before it.
  const int64_t low = -1 - start, high = length - start;
  const int64_t first = std::max<int64_t>(0, direction > 0 ? low : -high);
  const int64_t last = std::min(steps, direction > 0 ? high : -low);
  for (int64_t i = first; i <= last; ++i) {
    const int64_t away = steps == 0 ? 0 : (2 * i * std::abs(rise) + steps) / (2 * steps);
    const int64_t along = start + direction * i, beside = across + side * away;
    const int64_t x = is_steep ? beside : along, y = is_steep ? along : beside;
    set(x, y, color);
    if (thickness < 2) continue;
    set(x + 1, y, color);
    set(x, y + 1, color);
  }
}

void RgbaFrame::text(int64_t x, int64_t y, std::string_view text, Rgba color) noexcept {
  x = bounded(x), y = bounded(y);
  const auto paint = std::bit_cast<uint32_t>(color);
  const int64_t first = std::clamp<int64_t>(-y, 0, kGlyphHeight);
  const int64_t last = std::clamp<int64_t>(height_ - y, 0, kGlyphHeight);
  for (const char character : text) {
    if (x + kGlyphWidth > width_) return;
    const Glyph& glyph = get_glyph(character);
    const int64_t hidden = std::clamp<int64_t>(-x, 0, kGlyphWidth);  // columns left of the frame
    for (int64_t row = first; row < last; ++row) {
      const auto cell = glyph_row(glyph[static_cast<size_t>(row)], paint);
      uint32_t* to = pixels_ + (y + row) * width_ + x + hidden;
      if (hidden == 0)
        std::memcpy(to, cell.data(), sizeof cell);
      else if (hidden < kGlyphWidth)
        std::copy(cell.begin() + hidden, cell.end(), to);
    }
    x += kGlyphAdvance;
  }
}

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
