// Compares tinted masks and class maps with pixels that are mixed one by one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/tint.hpp"

#include <cmath>
#include <map>
#include <random>

#include "core/draw/draw_test_support.hpp"

namespace weir::draw {
namespace tint_test {

constexpr Rgb kColor{200, 30, 90};

uint8_t mixed(unsigned ground, unsigned color, unsigned opacity) {
  return static_cast<uint8_t>((2 * (ground * (255 - opacity) + color * opacity) + 255) / 510);
}

// Bilinear between the centres of the mask's elements.
double value_at(const std::vector<uint8_t>& mask, uint32_t width, uint32_t height, double x,
                double y) {
  x = std::clamp(x * width - 0.5, 0.0, width - 1.0);
  y = std::clamp(y * height - 0.5, 0.0, height - 1.0);
  const auto x0 = static_cast<size_t>(x), y0 = static_cast<size_t>(y);
  const size_t x1 = std::min<size_t>(x0 + 1, width - 1), y1 = std::min<size_t>(y0 + 1, height - 1);
  const double u = x - double(x0), v = y - double(y0);
  return (mask[y0 * width + x0] * (1 - u) + mask[y0 * width + x1] * u) * (1 - v) +
         (mask[y1 * width + x0] * (1 - u) + mask[y1 * width + x1] * u) * v;
}

TEST(MaskTinter, TintsThePixelsAboveOneHalf) {
  std::mt19937 random(5);
  for (const auto& [width, height] : {std::pair{1u, 1u}, {4u, 3u}, {16u, 16u}}) {
    std::vector<uint8_t> mask(width * height);
    for (auto& value : mask) value = static_cast<uint8_t>(random());
    for (const Area& area : {Area{3, 2, 43, 32}, Area{-10, -7, 30, 20}, Area{20, 10, 90, 70}}) {
      TestPicture picture("GRAY8", 50, 40);
      auto canvas = picture.canvas();
      MaskTinter().tint(area, {width, height, mask}, 100, make_paint(picture.picture, kColor),
                        &canvas);
      const uint8_t tinted = mixed(7, to_samples(picture.picture, kColor)[0], 100);
      for (int64_t y = 0; y < 40; ++y)
        for (int64_t x = 0; x < 50; ++x) {
          const bool is_in = x >= area.left && x < area.right && y >= area.top && y < area.bottom;
          const double value =
              is_in ? value_at(mask, width, height,
                               (double(x - area.left) + 0.5) / double(area.right - area.left),
                               (double(y - area.top) + 0.5) / double(area.bottom - area.top))
                    : 0;
          if (std::abs(value - 127.5) < 1) continue;  // rows have weights of 1 / 256
          EXPECT_EQ(*picture.sample(0, x, y), value > 127.5 ? tinted : 7)
              << x << "," << y << " " << value;
        }
    }
  }
}

TEST(MaskTinter, MixesEverySampleOnceInEveryFormat) {
  const std::vector<uint8_t> all(4, 255);
  for (const auto& format : every_format())
    for (const auto& [width, height] : {std::pair{100u, 30u}, {7u, 5u}}) {
      TestPicture picture(format, width, height);
      auto canvas = picture.canvas();
      MaskTinter().tint(canvas.all(), {2, 2, all}, 77, make_paint(picture.picture, kColor),
                        &canvas);
      const auto samples = to_samples(picture.picture, kColor);
      for (size_t component = 0; component < picture.components().size(); ++component)
        for (int64_t y = 0; y < height; ++y)
          for (int64_t x = 0; x < width; ++x)
            ASSERT_EQ(*picture.sample(component, x, y), mixed(7, samples[component], 77))
                << format << " component " << component << " at " << x << "," << y;
      EXPECT_EQ(picture.memory[0][2], std::byte{7});
    }
}

TEST(TintClasses, PixelsTakeTheNearestClass) {
  std::mt19937 random(9);
  const uint32_t width = 9, height = 5;
  std::vector<uint16_t> classes(width * height);
  for (auto& value : classes) value = static_cast<uint16_t>(random() % 3);
  for (const Area& area : {Area{0, 0, 50, 40}, Area{-6, 3, 30, 77}, Area{10, 5, 14, 8}}) {
    TestPicture picture("RGB", 50, 40);
    auto canvas = picture.canvas();
    std::map<uint16_t, Paint> paints{{1, make_paint(picture.picture, class_color(1))},
                                     {2, make_paint(picture.picture, class_color(2))}};
    tint_classes(
        area, width, height, classes, 128,
        [&](uint16_t c) { return paints.contains(c) ? &paints[c] : nullptr; }, &canvas);
    for (int64_t y = 0; y < 40; ++y)
      for (int64_t x = 0; x < 50; ++x) {
        uint8_t wanted = 7;
        if (x >= area.left && x < area.right && y >= area.top && y < area.bottom) {
          const auto column = static_cast<size_t>((double(x - area.left) + 0.5) * width /
                                                  double(area.right - area.left));
          const auto row = static_cast<size_t>((double(y - area.top) + 0.5) * height /
                                               double(area.bottom - area.top));
          const uint16_t c = classes[row * width + column];
          if (c > 0) wanted = mixed(7, class_color(c).red, 128);
        }
        ASSERT_EQ(*picture.sample(0, x, y), wanted) << x << "," << y;
      }
  }
}

// Maps without rows or columns are those of a network that saw nothing.
TEST(TintClasses, MapsWithoutElementsChangeNothing) {
  for (const auto& [width, height] : {std::pair{5u, 0u}, {0u, 5u}, {0u, 0u}}) {
    TestPicture picture("RGB", 20, 10);
    auto canvas = picture.canvas();
    const Paint paint = make_paint(picture.picture, class_color(1));
    tint_classes(
        Area{0, 0, 20, 10}, width, height, {}, 128, [&](uint16_t) { return &paint; }, &canvas);
    for (int64_t y = 0; y < 10; ++y)
      for (int64_t x = 0; x < 20; ++x)
        ASSERT_EQ(*picture.sample(0, x, y), 7) << width << ":" << height << " at " << x << "," << y;
  }
}

}  // namespace tint_test
}  // namespace weir::draw
