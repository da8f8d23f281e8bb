// Colours and their samples.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/color.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "core/draw/draw_test_support.hpp"

namespace weir::draw {
namespace color_test {

using Samples = std::array<uint8_t, 3>;

preprocess::Picture picture(const char* format, preprocess::ColorMatrix matrix,
                            preprocess::ColorRange range) {
  preprocess::Picture out;
  out.format = *preprocess::picture_format(format);
  out.matrix = matrix;
  out.range = range;
  return out;
}

// The values that BT.601, BT.709 and BT.2020 list for the primaries.
TEST(DrawColor, IsThatOfTheStandardsInLimitedRange) {
  using preprocess::ColorMatrix;
  const auto limited = preprocess::ColorRange::Limited;
  const auto of = [&](ColorMatrix matrix, Rgb c) {
    return to_samples(picture("NV12", matrix, limited), c);
  };
  for (const auto matrix : {ColorMatrix::Bt601, ColorMatrix::Bt709, ColorMatrix::Bt2020}) {
    EXPECT_EQ(of(matrix, {255, 255, 255}), (Samples{235, 128, 128}));
    EXPECT_EQ(of(matrix, {0, 0, 0}), (Samples{16, 128, 128}));
  }
  EXPECT_EQ(of(ColorMatrix::Bt601, {255, 0, 0}), (Samples{81, 90, 240}));
  EXPECT_EQ(of(ColorMatrix::Bt601, {0, 255, 0}), (Samples{145, 54, 34}));
  EXPECT_EQ(of(ColorMatrix::Bt601, {0, 0, 255}), (Samples{41, 240, 110}));
  EXPECT_EQ(of(ColorMatrix::Bt709, {255, 0, 0}), (Samples{63, 102, 240}));
  EXPECT_EQ(of(ColorMatrix::Bt709, {0, 255, 0}), (Samples{173, 42, 26}));
  EXPECT_EQ(of(ColorMatrix::Bt2020, {0, 0, 255}), (Samples{29, 240, 119}));
}

TEST(DrawColor, UsesTheWholeRangeWhereThePictureDoes) {
  const auto full = preprocess::ColorRange::Full;
  const auto nv12 = picture("NV12", preprocess::ColorMatrix::Bt601, full);
  EXPECT_EQ(to_samples(nv12, {255, 0, 0}), (Samples{76, 85, 255}));
  EXPECT_EQ(to_samples(nv12, {255, 255, 255}), (Samples{255, 128, 128}));
  const auto gray = picture("GRAY8", preprocess::ColorMatrix::Bt709, full);
  EXPECT_EQ(to_samples(gray, {0, 255, 0})[0], 150);
  const auto studio =
      picture("GRAY8", preprocess::ColorMatrix::Bt709, preprocess::ColorRange::Limited);
  EXPECT_EQ(to_samples(studio, {255, 255, 255})[0], 235);
}

TEST(DrawColor, IsPlacedInEachFormatWhereItsComponentsAre) {
  const Rgb color{1, 2, 3};
  const auto first_pixel = [&](const char* format) {
    const auto paint = make_paint(
        picture(format, preprocess::ColorMatrix::Bt601, preprocess::ColorRange::Full), color);
    return std::vector<uint8_t>(paint.planes[0].begin(), paint.planes[0].begin() + 4);
  };
  EXPECT_EQ(first_pixel("RGB"), (std::vector<uint8_t>{1, 2, 3, 1}));
  EXPECT_EQ(first_pixel("BGRA"), (std::vector<uint8_t>{3, 2, 1, 255}));
  EXPECT_EQ(first_pixel("ARGB"), (std::vector<uint8_t>{255, 1, 2, 3}));
  EXPECT_EQ(first_pixel("xBGR"), (std::vector<uint8_t>{255, 3, 2, 1}));
}

TEST(DrawColor, OfNeighbouringClassesIsFarApart) {
  for (uint64_t i = 0; i < 100; ++i)
    for (const uint64_t next : {i + 1, i + 2}) {
      const Rgb a = class_color(i), b = class_color(next);
      const int distance =
          std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue);
      EXPECT_GT(distance, 100) << i << " and " << next;
    }
  EXPECT_EQ(class_color(0), (Rgb{38, 255, 38}));
  class_color(UINT64_MAX);
}

TEST(DrawColor, OfTextContrastsWithItsBackground) {
  EXPECT_EQ(text_color({255, 255, 0}), (Rgb{0, 0, 0}));
  EXPECT_EQ(text_color({0, 0, 255}), (Rgb{255, 255, 255}));
}

}  // namespace color_test
}  // namespace weir::draw
