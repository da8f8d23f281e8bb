// Tests of run-length codes of masks, against pixels and codes of COCO.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/run_lengths.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace weir::records {
namespace run_lengths_test {

// The picture of a code, row after row.
std::vector<int> pixels_of(const RunLengths& runs, size_t width, size_t height) {
  std::vector<int> down;
  int value = 0;
  for (const uint32_t run : runs) {
    down.insert(down.end(), run, value);
    value = 1 - value;
  }
  EXPECT_EQ(down.size(), width * height);
  std::vector<int> out(width * height);
  for (size_t x = 0; x < width; ++x)
    for (size_t y = 0; y < height; ++y) out[y * width + x] = down.at(x * height + y);
  return out;
}

TEST(RunLengths, StartWithPixelsThatAreNotSet) {
  const std::vector<std::byte> full{std::byte{255}}, empty{std::byte{127}};
  EXPECT_EQ(runs_of_mask({1, 1, full}, {0, 0, 2, 3}, 2, 3), (RunLengths{0, 6}));
  EXPECT_EQ(runs_of_mask({1, 1, empty}, {0, 0, 2, 3}, 2, 3), (RunLengths{6}));
  EXPECT_EQ(runs_of_mask({1, 1, full}, {1, 1, 2, 2}, 3, 3), (RunLengths{4, 1, 4}));
  EXPECT_EQ(runs_of_mask({1, 1, full}, {5, 5, 1, 1}, 2, 2), (RunLengths{4}));  // no area
}

TEST(RunLengths, OfMasksAreTheNearestCellOfEachPixel) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-10, 40);
  for (int i = 0; i < 200; ++i) {
    const uint32_t w = 1 + random() % 7, h = 1 + random() % 7;
    std::vector<std::byte> values(size_t{w} * h);
    for (auto& value : values) value = static_cast<std::byte>(random());
    const float x = place(random), y = place(random);
    const Box box{x, y, x + 1 + place(random) + 10, y + 1 + place(random) + 10};
    const auto pixels = pixels_of(runs_of_mask({w, h, values}, box, 31, 23), 31, 23);
    for (uint32_t py = 0; py < 23; ++py)
      for (uint32_t px = 0; px < 31; ++px) {
        const double u = (px + 0.5 - double{box.x1}) / (double{box.x2} - double{box.x1}) * w;
        const double v = (py + 0.5 - double{box.y1}) / (double{box.y2} - double{box.y1}) * h;
        const bool inside = u >= 0 && v >= 0 && u < w && v < h;
        const int expected =
            inside && std::to_integer<int>(values[size_t(v) * w + size_t(u)]) >= 128;
        ASSERT_EQ(pixels[py * 31 + px], expected) << px << ' ' << py;
      }
  }
}

TEST(RunLengths, TextIsThatOfCoco) {
  // Five bits a character from the lowest on, from '0' on, 32 = more follow.
  EXPECT_EQ(to_string({6}), "6");
  EXPECT_EQ(to_string({0, 6}), "06");
  EXPECT_EQ(to_string({16}), "`0");  // bit 4 of the last character would be a sign
  EXPECT_EQ(to_string({100}), "T3");
  // From the fourth run on, the difference to the run before the last one: 3 - 5 = -2.
  EXPECT_EQ(to_string({1, 5, 2, 3}), "152N");
  // Sign-extended differences of more than four bits: 5 - 1000 = -995.
  EXPECT_EQ(to_string({0, 1000, 2, 5}), "0Xo02mPO");
}

TEST(RunLengths, OfATextAreThoseThatWereWritten) {
  for (const RunLengths& runs : {RunLengths{6},
                                 {0, 6},
                                 {16},
                                 {100},
                                 {1, 5, 2, 3},
                                 {0, 1000, 2, 5},
                                 {7, 1, 4000000, 1, 3, 123456}}) {
    const uint64_t pixels = std::accumulate(runs.begin(), runs.end(), uint64_t{0});
    EXPECT_EQ(runs_of_text(to_string(runs), pixels), runs) << to_string(runs);
  }
}

TEST(RunLengths, OfADamagedTextAreNone) {
  EXPECT_FALSE(runs_of_text("152N", 12));  // 11 pixels
  EXPECT_FALSE(runs_of_text("152N", 10));
  EXPECT_FALSE(runs_of_text("15\x7f", 11));
  EXPECT_FALSE(runs_of_text("1 5", 11));
  EXPECT_FALSE(runs_of_text("`", 16));            // the last group says that more follow
  EXPECT_FALSE(runs_of_text("oooooooooo0", 16));  // more bits than a run has
  EXPECT_FALSE(runs_of_text("O", 16));            // -1
  EXPECT_FALSE(runs_of_text("", 1));
  EXPECT_TRUE(runs_of_text("", 0));
}

TEST(RunLengths, OfClassesCoverTheMapInThePicture) {
  // A map of 2 x 1 cells over the right half of a picture of 4 x 2.
  const std::vector<std::byte> values{std::byte{0}, std::byte{3}};
  SourceMap map;
  map.x0 = 2, map.yy = 2;
  const auto found = runs_of_classes({.width = 2, .height = 1, .values = values}, map, 4, 2);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].class_index, 0u);
  EXPECT_EQ(pixels_of(found[0].runs, 4, 2), (std::vector<int>{0, 0, 1, 0, 0, 0, 1, 0}));
  EXPECT_EQ(found[1].class_index, 3u);
  EXPECT_EQ(pixels_of(found[1].runs, 4, 2), (std::vector<int>{0, 0, 0, 1, 0, 0, 0, 1}));
  map.xx = 0;  // singular
  EXPECT_TRUE(runs_of_classes({.width = 2, .height = 1, .values = values}, map, 4, 2).empty());
}

TEST(RunLengths, OfWideClassMapsHaveTheirClasses) {
  const uint16_t classes[] = {300, 300};
  const auto found = runs_of_classes(
      {.width = 1, .height = 2, .is_wide = true, .values = std::as_bytes(std::span(classes))}, {},
      1, 2);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].class_index, 300u);
  EXPECT_EQ(found[0].runs, (RunLengths{0, 2}));
}

TEST(RunLengths, HugePicturesHaveNone) {
  EXPECT_TRUE(has_run_lengths(16384, 16384));
  EXPECT_FALSE(has_run_lengths(16385, 16384));
  EXPECT_FALSE(has_run_lengths(UINT32_MAX, UINT32_MAX));
  EXPECT_FALSE(has_run_lengths(0, 5));
}

}  // namespace run_lengths_test
}  // namespace weir::records
