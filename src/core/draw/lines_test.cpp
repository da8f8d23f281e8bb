// Compares polygons and lines with pixels that are tested one by one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/lines.hpp"

#include <cmath>
#include <random>

#include "core/draw/draw_test_support.hpp"

namespace weir::draw {
namespace lines_test {

constexpr Rgb kColor{200, 30, 90};

bool is_painted(TestPicture* picture, int64_t x, int64_t y) {
  return *picture->sample(0, x, y) != 7;
}

TEST(FillConvex, PaintsPixelsWhoseCentreIsInside) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20, 60);
  for (int run = 0; run < 200; ++run) {
    std::array<Point, 3> triangle;
    for (Point& corner : triangle) corner = {place(random), place(random)};
    TestPicture picture("GRAY8", 40, 30);
    auto canvas = picture.canvas();
    fill_convex(triangle, make_paint(picture.picture, kColor), &canvas);
    for (int64_t y = 0; y < 30; ++y)
      for (int64_t x = 0; x < 40; ++x) {
        // Inside when the centre is on the same side of all edges.
        int left = 0, right = 0;
        bool is_near = false;
        for (size_t i = 0; i < 3; ++i) {
          const Point a = triangle[i], b = triangle[(i + 1) % 3];
          const double side =
              (b.x - a.x) * (double(y) + 0.5 - a.y) - (b.y - a.y) * (double(x) + 0.5 - a.x);
          (side > 0 ? left : right)++;
          is_near = is_near || std::abs(side) < 1e-6;
        }
        if (is_near) continue;
        EXPECT_EQ(is_painted(&picture, x, y), left == 3 || right == 3) << x << "," << y;
      }
  }
}

TEST(DrawLine, HasItsWidthInEveryDirection) {
  for (const double width : {1.0, 2.0, 5.0})
    for (int degrees = 4; degrees < 360; degrees += 14) {
      TestPicture picture("GRAY8", 101, 101);
      auto canvas = picture.canvas();
      const double angle = degrees * 3.14159265358979 / 180;
      const Point from{50.5, 50.5}, to{50.5 + 40 * std::cos(angle), 50.5 + 40 * std::sin(angle)};
      draw_line(from, to, width, make_paint(picture.picture, kColor), &canvas);
      int painted = 0;
      for (int64_t y = 0; y < 101; ++y)
        for (int64_t x = 0; x < 101; ++x) painted += is_painted(&picture, x, y);
      const double steeper = std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
      EXPECT_NEAR(painted, 40 * std::max(width, steeper), 10) << degrees << " degrees";
    }
}

TEST(DrawLine, OfOnePixelHasNoGaps) {
  for (const double slope : {0.0, 0.3, 0.7, 1.0}) {
    TestPicture picture("GRAY8", 50, 50);
    auto canvas = picture.canvas();
    draw_line({0, 2}, {50, 2 + 45 * slope}, 0.1, make_paint(picture.picture, kColor), &canvas);
    for (int64_t x = 1; x < 49; ++x) {
      int painted = 0;
      for (int64_t y = 0; y < 50; ++y) painted += is_painted(&picture, x, y);
      EXPECT_GE(painted, 1) << slope << " at " << x;
    }
  }
}

TEST(DrawLine, NothingThatIsNotFiniteOrHasNoLength) {
  TestPicture picture("NV12", 20, 20);
  auto canvas = picture.canvas();
  const Paint paint = make_paint(picture.picture, kColor);
  draw_line({NAN, 0}, {10, 10}, 2, paint, &canvas);
  draw_line({0, 0}, {INFINITY, 10}, 2, paint, &canvas);
  draw_line({5, 5}, {5, 5}, 2, paint, &canvas);
  draw_line({5, 5}, {15, 5}, 0, paint, &canvas);
  draw_line({5, 5}, {15, 5}, NAN, paint, &canvas);
  EXPECT_EQ(picture, TestPicture("NV12", 20, 20));
  // Far ends cost no more than the picture has rows.
  draw_line({-1e30, 10}, {1e30, 10}, 2, paint, &canvas);
  EXPECT_TRUE(is_painted(&picture, 3, 10));
}

TEST(DrawOutline, OfARotatedRectangleLeavesTheInsideFree) {
  TestPicture picture("GRAY8", 60, 60);
  auto canvas = picture.canvas();
  const std::array<Point, 4> diamond{{{30, 5}, {55, 30}, {30, 55}, {5, 30}}};
  draw_outline(diamond, 2, make_paint(picture.picture, kColor), &canvas);
  EXPECT_FALSE(is_painted(&picture, 30, 30));
  EXPECT_TRUE(is_painted(&picture, 42, 17));
  EXPECT_TRUE(is_painted(&picture, 17, 42));
  EXPECT_FALSE(is_painted(&picture, 5, 5));
}

}  // namespace lines_test
}  // namespace weir::draw
