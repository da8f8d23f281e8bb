// Compares areas and masks with pixels that are set one by one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/canvas.hpp"

#include <random>

#include "core/draw/draw_test_support.hpp"
#include "says.hpp"

namespace weir::draw {
namespace canvas_test {

void set_area(TestPicture* picture, const Area& area, Rgb color) {
  for (int64_t y = area.top; y < area.bottom; ++y)
    for (int64_t x = area.left; x < area.right; ++x) picture->set(x, y, color);
}

TEST(Canvas, FillsWhatPixelsOneByOneWould) {
  std::mt19937 random(1);
  for (const auto& format : every_format())
    for (const bool bottom_up : {false, true})
      for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 33u}}) {
        TestPicture drawn(format, width, height, bottom_up);
        TestPicture expected(format, width, height, bottom_up);
        auto canvas = drawn.canvas();
        std::uniform_int_distribution<int64_t> place(-10, 80);
        for (uint64_t i = 0; i < 30; ++i) {
          const Area area{place(random), place(random), place(random), place(random)};
          const Rgb color = class_color(i);
          canvas.fill(area, make_paint(drawn.picture, color));
          set_area(&expected, area, color);
        }
        EXPECT_EQ(drawn, expected) << format << " " << width << "x" << height;
      }
}

TEST(Canvas, IsNotDrawnOnBeyondItsPicture) {
  for (const auto& format : every_format()) {
    TestPicture picture(format, 6, 4);
    auto canvas = picture.canvas();
    const Paint paint = make_paint(picture.picture, {255, 0, 0});
    constexpr int64_t kFar = 1000000000;
    for (const Area& area : {Area{-kFar, -kFar, 0, kFar}, Area{6, 0, kFar, 4}, Area{0, 4, 6, kFar},
                             Area{0, -kFar, 6, 0}, Area{3, 2, 3, 4}, Area{5, 3, 1, 1}})
      canvas.fill(area, paint);
    EXPECT_EQ(picture, TestPicture(format, 6, 4)) << format;
    canvas.fill({-kFar, -kFar, kFar, kFar}, paint);
    for (const auto& component : picture.components())  // bytes between rows belong to no pixel
      EXPECT_EQ(picture.memory[component.plane][2], std::byte{7});
    EXPECT_EQ(picture.memory[0].back(), std::byte{7});
  }
}

Mask random_mask(uint32_t width, uint32_t height) {
  std::mt19937 random(width * 100 + height);
  Mask out{width, height, {}};
  for (uint32_t i = 0; i < width * height; ++i)
    out.coverage.push_back(static_cast<uint8_t>(random() % 3 == 0 ? 255 : random() % 256));
  return out;
}
uint8_t mixed(unsigned ground, unsigned color, unsigned coverage) {
  return static_cast<uint8_t>((2 * (ground * (255 - coverage) + color * coverage) + 255) / 510);
}
// The mean of the pixels of a sample; pixels beyond the mask count as 0.
unsigned coverage_at(const Mask& mask, int64_t x, int64_t y,
                     const preprocess::Component& component) {
  const auto at = [&](int64_t column, int64_t row) -> unsigned {
    if (column >= mask.width || row >= mask.height) return 0;
    return mask.coverage[static_cast<size_t>(row * mask.width + column)];
  };
  if (!component.halved_columns) return at(x, y);
  if (!component.halved_rows) return (at(x, y) + at(x + 1, y) + 1) / 2;
  return (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1) + 2) / 4;
}

TEST(Canvas, MixesAMaskIn) {
  for (const auto& format : every_format())
    for (const auto& [width, height] : {std::pair{1u, 1u}, {5u, 3u}, {97u, 12u}})
      for (const auto& [x, y] : {std::pair{0, 0}, {2, 4}, {38, 18}}) {
        TestPicture picture(format, 40, 20);
        const Mask mask = random_mask(width, height);
        const Rgb color{200, 30, 90};
        picture.canvas().blend(x, y, for_planes(mask, picture.picture.format),
                               make_paint(picture.picture, color));
        TestPicture expected(format, 40, 20);
        const auto samples = to_samples(picture.picture, color);
        for (size_t component = 0; component < expected.components().size(); ++component) {
          const preprocess::Component& grid = expected.components()[component];
          for (int64_t row = 0; row < 20; row += grid.halved_rows ? 2 : 1)
            for (int64_t column = 0; column < 40; column += grid.halved_columns ? 2 : 1) {
              if (column < x || row < y) continue;
              uint8_t* sample = expected.sample(component, column, row);
              *sample = mixed(7, samples[component], coverage_at(mask, column - x, row - y, grid));
            }
        }
        for (size_t component = 0; component < expected.components().size(); ++component)
          for (int64_t row = 0; row < 20; ++row)
            for (int64_t column = 0; column < 40; ++column)
              ASSERT_EQ(*picture.sample(component, column, row),
                        *expected.sample(component, column, row))
                  << format << " component " << component << " at " << column << "," << row;
        EXPECT_EQ(picture.memory[0][2], std::byte{7});
      }
}

TEST(Canvas, RefusesPlanesThatAreTooShort) {
  for (const auto& format : every_format()) {
    TestPicture picture(format, 30, 20);
    ASSERT_TRUE(Canvas::make(picture.picture, picture.planes));
    const size_t last = picture.picture.format.plane_count() - 1;
    const Plane whole = picture.planes[last];
    const auto refused = [&](const char* what) {
      const auto canvas = Canvas::make(picture.picture, picture.planes);
      ASSERT_FALSE(canvas) << format << " " << what;
      EXPECT_EQ(canvas.error().code, Code::FRAME_SIZE);
      EXPECT_SAYS(canvas.error().message(), "shorter than its size requires");
      picture.planes[last] = whole;
    };
    picture.planes[last].memory = whole.memory.first(whole.memory.size() - 6);
    refused("a byte less");
    picture.planes[last].stride = -whole.stride;
    refused("rows before the memory");
    picture.planes[last].offset = SIZE_MAX;
    refused("an enormous offset");
    picture.planes[last].stride = PTRDIFF_MIN;
    refused("an enormous stride");
  }
}

}  // namespace canvas_test
}  // namespace weir::draw
