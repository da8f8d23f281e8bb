// Tests of the colours of classes and gray levels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/class_colors.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

namespace weir::draw {
namespace class_colors_test {

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

}  // namespace class_colors_test
}  // namespace weir::draw
