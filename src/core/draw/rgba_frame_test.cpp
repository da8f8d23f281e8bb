// Compares shapes with pixels that are set one by one, and parts of frames with whole ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <set>
#include <vector>

#include "core/draw/glyphs.hpp"
#include "core/draw/rgba_frame.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::draw {
namespace rgba_frame_test {

constexpr int64_t kLow = std::numeric_limits<int32_t>::min();
constexpr int64_t kHigh = std::numeric_limits<int32_t>::max();

struct TestFrame {
  explicit TestFrame(Size frame_size)
      : size(frame_size), bytes(draw::rgba_bytes(frame_size)), frame(bytes, frame_size) {}
  TestFrame(const TestFrame&) = delete;
  TestFrame& operator=(const TestFrame&) = delete;
  Rgba at(int64_t x, int64_t y) const {
    const auto* pixels = reinterpret_cast<const Rgba*>(bytes.data());
    return pixels[y * size.width + x];
  }
  size_t drawn() const {
    size_t count = 0;
    for (int64_t y = 0; y < size.height; ++y)
      for (int64_t x = 0; x < size.width; ++x) count += at(x, y) != kTransparent;
    return count;
  }
  Size size;
  std::vector<std::byte> bytes;
  RgbaFrame frame;
};

TEST(RgbaFrame, OutlinesWhatPixelsOneByOneWould) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int64_t> place(-6, 20);
  for (int i = 0; i < 400; ++i) {
    TestFrame drawn({13, 9}), expected({13, 9});
    const int64_t left = place(random), top = place(random);
    const int64_t right = place(random), bottom = place(random);
    drawn.frame.outline(left, top, right, bottom, kRed);
    for (int64_t x = left; x <= right; ++x)
      for (const int64_t y : {top, bottom}) expected.frame.set(x, y, kRed);
    for (int64_t y = top + 1; y <= bottom - 1; ++y)
      for (const int64_t x : {left, right}) expected.frame.set(x, y, kRed);
    EXPECT_EQ(drawn.bytes, expected.bytes) << left << " " << top << " " << right << " " << bottom;
  }
}

TEST(RgbaFrame, ClipsOutlinesWithAnyCoordinates) {
  TestFrame around({8, 4});
  around.frame.outline(kLow, kLow, kHigh, kHigh, kRed);
  EXPECT_EQ(around.drawn(), 0u);
  TestFrame through({8, 4});
  through.frame.outline(kLow, 1, kHigh, kHigh, kRed);
  EXPECT_EQ(through.drawn(), 8u) << "the upper edge";
}

TEST(RgbaFrame, DrawsTheNearestPixelOfEachStepOfALine) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int64_t> place(0, 30);
  for (int i = 0; i < 300; ++i) {
    TestFrame drawn({31, 31});
    const int64_t x1 = place(random), y1 = place(random), x2 = place(random), y2 = place(random);
    drawn.frame.line(x1, y1, x2, y2, kRed);
    const int64_t steps = std::max(std::abs(x2 - x1), std::abs(y2 - y1));
    EXPECT_EQ(drawn.drawn(), static_cast<size_t>(steps + 1));
    EXPECT_EQ(drawn.at(x1, y1), kRed);
    EXPECT_EQ(drawn.at(x2, y2), kRed);
    for (int64_t y = 0; y < 31; ++y)
      for (int64_t x = 0; x < 31; ++x)
        if (drawn.at(x, y) == kRed && steps > 0) {
          // The distance from the ideal line along the shorter axis, times the longer one.
          const int64_t away = std::abs((x2 - x1) * (y - y1) - (y2 - y1) * (x - x1));
          EXPECT_LE(2 * away, steps) << x << " " << y;
        }
  }
}

TEST(RgbaFrame, DrawsThePartOfALineThatIsInTheFrame) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int64_t> place(0, 59);
  constexpr int64_t kLeft = 20, kTop = 25;
  for (const int thickness : {1, 2})
    for (int i = 0; i < 300; ++i) {
      TestFrame whole({60, 60}), part({17, 11});
      const int64_t x1 = place(random), y1 = place(random), x2 = place(random), y2 = place(random);
      whole.frame.line(x1, y1, x2, y2, kWhite, thickness);
      part.frame.line(x1 - kLeft, y1 - kTop, x2 - kLeft, y2 - kTop, kWhite, thickness);
      for (int64_t y = 0; y < 11; ++y)
        for (int64_t x = 0; x < 17; ++x)
          EXPECT_EQ(part.at(x, y), whole.at(kLeft + x, kTop + y)) << x << " " << y;
    }
}

TEST(RgbaFrame, AThickLineAlsoSetsThePixelsRightAndBelow) {
  TestFrame drawn({6, 6}), expected({6, 6});
  drawn.frame.line(1, 1, 3, 3, kWhite, 2);
  for (const auto& [x, y] : {std::pair{1, 1}, {2, 2}, {3, 3}})
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}})
      expected.frame.set(x + dx, y + dy, kWhite);
  EXPECT_EQ(drawn.bytes, expected.bytes);
}

// Ends in time because the cost depends on the pixels in the frame only.
TEST(RgbaFrame, DrawsLinesWithAnyCoordinates) {
  TestFrame drawn({8, 4});
  for (int i = 0; i < 10'000; ++i) drawn.frame.line(kLow, 2, kHigh, 2, kRed);
  EXPECT_EQ(drawn.drawn(), 8u);
  drawn.frame.line(kLow, kLow, kLow, kHigh, kRed);
  drawn.frame.line(3, kHigh, kHigh, kHigh, kRed);
  EXPECT_EQ(drawn.drawn(), 8u);
}

TEST(RgbaFrame, WritesCellsCompletely) {
  TestFrame drawn({30, 20});
  for (int64_t y = 0; y < 20; ++y) drawn.frame.line(0, y, 29, y, kWhite);
  drawn.frame.text(2, 3, "A ", kRed);
  for (int64_t y = 0; y < 20; ++y)
    for (int64_t x = 0; x < 30; ++x) {
      const bool is_in_rows = y >= 3 && y < 16;
      const bool is_first = is_in_rows && x >= 2 && x < 10;
      const bool is_second = is_in_rows && x >= 11 && x < 19;
      const bool is_set = is_first && get_glyph('A')[y - 3] & (0x80 >> (x - 2));
      const Rgba expected = is_set ? kRed : is_first || is_second ? kTransparent : kWhite;
      EXPECT_EQ(drawn.at(x, y), expected) << x << " " << y;
    }
}

TEST(RgbaFrame, EndsALabelBeforeTheCellThatDoesNotFit) {
  for (const auto& [width, cells] : {std::pair{7u, 0u}, {8u, 1u}, {16u, 1u}, {17u, 2u}}) {
    TestFrame drawn({width, 13}), expected({width, 13});
    drawn.frame.text(0, 0, "###", kRed);
    expected.frame.text(0, 0, std::string(cells, '#'), kRed);
    EXPECT_EQ(drawn.bytes, expected.bytes) << width;
    EXPECT_EQ(drawn.drawn() > 0, cells > 0) << width;
  }
}

TEST(RgbaFrame, ClipsTextAtEveryEdge) {
  TestFrame whole({60, 60}), part({20, 9});
  whole.frame.text(14, 18, "xyz", kRed);
  part.frame.text(-6, -2, "xy", kRed);  // z would begin at 12 and reach 20, the edge
  for (int64_t y = 0; y < 9; ++y)
    for (int64_t x = 0; x < 11; ++x) EXPECT_EQ(part.at(x, y), whole.at(20 + x, 20 + y));
  TestFrame nothing({20, 9});
  for (const int64_t y : {kLow, int64_t{-13}, int64_t{9}, kHigh})
    nothing.frame.text(0, y, "x", kRed);
  nothing.frame.text(kHigh, 0, "x", kRed);
  nothing.frame.text(kLow, 0, "x", kRed);
  EXPECT_EQ(nothing.drawn(), 0u);
}

TEST(RgbaFrame, ClearMakesEveryPixelTransparent) {
  TestFrame drawn({5, 3});
  drawn.bytes.assign(drawn.bytes.size(), std::byte{7});
  drawn.frame.clear();
  EXPECT_EQ(drawn.drawn(), 0u);
}

TEST(Glyphs, EachPrintableCharacterHasItsOwn) {
  std::set<Glyph> all;
  for (char c = ' '; c <= '~'; ++c) all.insert(get_glyph(c));
  EXPECT_EQ(all.size(), 95u);
  EXPECT_EQ(get_glyph(' '), Glyph{});
}

TEST(Glyphs, EveryOtherByteIsAStar) {
  for (int byte = 0; byte < 256; ++byte) {
    if (byte >= 32 && byte <= 126) continue;
    EXPECT_EQ(get_glyph(static_cast<char>(byte)), get_glyph('*')) << byte;
  }
}

// The pixel as a little-endian number.
uint32_t number_of(Rgba pixel) {
  return pixel.red | uint32_t{pixel.green} << 8 | uint32_t{pixel.blue} << 16 |
         uint32_t{pixel.alpha} << 24;
}

TEST(SpreadColors, LeavesTheBackgroundTransparent) {
  for (const size_t classes : {1u, 2u, 21u}) EXPECT_EQ(spread_colors(classes)[0], kTransparent);
}

// docs/compatibility/decoder.md 5.5: 0xFFFFFF / 21 is 798915 = 0x0C30C3.
TEST(SpreadColors, AreMultiplesOfOneNumber) {
  const auto colors = spread_colors(21);
  ASSERT_EQ(colors.size(), 21u);
  EXPECT_EQ(colors[1], (Rgba{0xC3, 0x30, 0x0C, 0xFF}));
  EXPECT_EQ(colors[2], (Rgba{0x86, 0x61, 0x18, 0xFF}));
  for (uint32_t i = 1; i < 21; ++i) EXPECT_EQ(number_of(colors[i]), 798915 * i | 0xFF000000) << i;
}

TEST(SpreadColors, DifferForEachClass) {
  for (const size_t classes : {2u, 3u, 256u, 65536u}) {
    std::set<uint32_t> different;
    for (const Rgba color : spread_colors(classes)) different.insert(number_of(color));
    EXPECT_EQ(different.size(), classes);
  }
}

TEST(PaintClasses, LooksUpEachPixel) {
  const std::vector<uint16_t> map{0, 2, 1, 2};
  const std::vector<Rgba> colors{kTransparent, kRed, kWhite};
  std::vector<Rgba> pixels(4, Rgba{1, 2, 3, 4});
  paint_classes(map, colors, pixels);
  EXPECT_EQ(pixels, (std::vector<Rgba>{kTransparent, kWhite, kRed, kWhite}));
}

TEST(PaintGrays, IsOpaque) {
  const std::vector<uint8_t> grays{0, 7, 255};
  std::vector<Rgba> pixels(3);
  paint_grays(grays, pixels);
  EXPECT_EQ(pixels, (std::vector<Rgba>{{0, 0, 0, 255}, {7, 7, 7, 255}, {255, 255, 255, 255}}));
}

}  // namespace rgba_frame_test
}  // namespace weir::draw
