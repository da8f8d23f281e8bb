// Compares drawings with pixels that are set one by one by the rules of the header.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/overlay.hpp"

#include <cmath>
#include <limits>

#include "core/draw/draw_test_support.hpp"

namespace weir::draw {
namespace overlay_test {

Detections boxes(std::vector<Detection> rows) {
  Detections out;
  out.rows = std::move(rows);
  return out;
}

// The rules for each pixel of the picture, without optimisation.
void reference(const Detections& d, const Style& style, TestPicture* out) {
  const double xs = d.picture_width ? double(out->picture.width) / d.picture_width : 1;
  const double ys = d.picture_height ? double(out->picture.height) / d.picture_height : 1;
  for (size_t i = 0; i < d.rows.size(); ++i) {
    const Detection& r = d.rows[i];
    const double left = std::floor(r.x1 * xs + 0.5), top = std::floor(r.y1 * ys + 0.5);
    const double right = std::max(left + 1, std::floor(r.x2 * xs + 0.5));
    const double bottom = std::max(top + 1, std::floor(r.y2 * ys + 0.5));
    const Rgb color = class_color(r.class_index);
    const double line = style.line_width;
    for (int64_t y = 0; y < out->picture.height; ++y)
      for (int64_t x = 0; x < out->picture.width; ++x) {
        const double px = double(x), py = double(y);
        const bool in = px >= left && px < right && py >= top && py < bottom;
        const bool inner =
            px >= left + line && px < right - line && py >= top + line && py < bottom - line;
        if (in && !inner && line > 0) out->set(x, y, color);
      }
    for (size_t p = 0; p < d.points_per_row; ++p) {
      const Point& point = d.points[i * d.points_per_row + p];
      const double size = style.point_size;
      const double cx = std::floor(point.x * xs - size / 2 + 0.5) + size / 2;
      const double cy = std::floor(point.y * ys - size / 2 + 0.5) + size / 2;
      for (int64_t y = 0; y < out->picture.height; ++y)
        for (int64_t x = 0; x < out->picture.width; ++x)
          if (std::hypot(double(x) + 0.5 - cx, double(y) + 0.5 - cy) <= size / 2)
            out->set(x, y, color);
    }
  }
}

void expect_same(const Detections& d, const Style& style, uint32_t width, uint32_t height) {
  for (const auto& format : every_format()) {
    TestPicture drawn(format, width, height), expected(format, width, height);
    auto canvas = drawn.canvas();
    draw(d, style, nullptr, &canvas);
    reference(d, style, &expected);
    EXPECT_EQ(drawn, expected) << format << " line " << style.line_width << " point "
                               << style.point_size;
  }
}

TEST(Overlay, DrawsBoxesToThePixel) {
  const auto d = boxes({{3, 4, 20, 15, 1, 0},
                        {10.4, 2.5, 30.6, 20.49, 1, 1},   // rounded to the nearest edges
                        {-5, -7, 8, 9, 1, 2},             // clipped at the left and the top
                        {35, 20, 90, 70, 1, 3},           // clipped at the right and the bottom
                        {-1e9, -1e30, 1e12, 1e38, 1, 4},  // far outside on all sides
                        {12, 12, 15, 14, 1, 5},           // nothing but the line
                        {0, 0, 0.2, 0.2, 1, 6},           // at least one pixel
                        {22, 3, 23, 18, 1, 7}});
  for (const uint32_t line : {0u, 1u, 2u, 3u, 9u}) expect_same(d, {line, 0, 0}, 41, 27);
  expect_same(d, {2, 0, 0}, 1, 1);
}

TEST(Overlay, DrawsKeyPointsAsDiscs) {
  auto d = boxes({{2, 2, 30, 20, 1, 0}, {10, 5, 20, 15, 1, 1}});
  d.points_per_row = 3;
  d.points = {{10.5, 10.5}, {20, 7.25}, {0, 0}, {40.9, 26.9}, {-100, 3}, {15.499, 3.501}};
  for (uint32_t size = 0; size <= 12; ++size) expect_same(d, {1, size, 0}, 41, 27);
  expect_same(d, {0, 256, 0}, 41, 27);
}

TEST(Overlay, LeavesOutPointsThatAreNotFinite) {
  auto d = boxes({{2, 2, 30, 20, 1, 0}});
  d.points_per_row = 2;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  d.points = {{nan, 3}, {3, std::numeric_limits<double>::infinity()}};
  TestPicture with("RGB", 40, 30), without("RGB", 40, 30);
  auto canvas = with.canvas();
  draw(d, {0, 5, 0}, nullptr, &canvas);
  EXPECT_EQ(with, without);
}

TEST(Overlay, ScalesFromAnotherPicture) {
  auto d = boxes({{6, 8, 40, 30, 1, 0}});
  d.points_per_row = 1;
  d.points = {{20, 20}};
  d.picture_width = 80;
  d.picture_height = 40;
  expect_same(d, {2, 4, 0}, 40, 40);
}

TEST(Overlay, CountsWhatItDrewAndWhatNot) {
  const auto d = boxes({{3, 4, 20, 15, 0.9f, 0},
                        {3, 4, 20, 15, 0.2f, 0},
                        {-9, 0, 0, 9, 0.9f, 0},
                        {50, 0, 60, 9, 0.9f, 0},
                        {50, 0, 60, 9, 0.1f, 0}});
  TestPicture picture("NV12", 40, 30);
  auto canvas = picture.canvas();
  const Drawn drawn = draw(d, {2, 5, 0.5f}, nullptr, &canvas);
  EXPECT_EQ(drawn.boxes, 1u);
  EXPECT_EQ(drawn.below_score, 2u);
  EXPECT_EQ(drawn.outside, 2u);
}

// Ten pixels high, four times as wide as the text is long, fully covered.
class Block : public TextPainter {
 public:
  Mask paint(const std::string& text) override {
    const auto width = static_cast<uint32_t>(4 * text.size());
    return {width, 10, std::vector<uint8_t>(10 * width, 255)};
  }
};

// The areas of the label and of its glyphs: gap 2, name, gap 2, score, gap 2.
void expect_label(const Detection& box, const Area& ground, std::vector<Area> inks,
                  const std::string& format, bool scores = true) {
  auto d = boxes({box});
  d.scored = true;
  TestPicture drawn(format, 80, 40), expected(format, 80, 40);
  Labels labels({{"cat"}}, scores, std::make_unique<Block>(), drawn.picture.format);
  auto canvas = drawn.canvas();
  draw(d, {1, 0, 0}, &labels, &canvas);
  reference(d, {1, 0, 0}, &expected);
  const Rgb color = class_color(box.class_index);
  const auto fill = [&](const Area& area, Rgb with) {
    for (int64_t y = area.top; y < area.bottom; ++y)
      for (int64_t x = area.left; x < area.right; ++x) expected.set(x, y, with);
  };
  fill(ground, color);
  for (const Area& ink : inks) fill(ink, text_color(color));
  EXPECT_EQ(drawn, expected) << format;
}

TEST(Overlay, PutsLabelsAboveTheirBoxes) {
  for (const auto& format : every_format()) {
    expect_label({8, 20, 60, 35, 0.5f, 0}, {8, 10, 42, 20}, {{10, 10, 22, 20}, {24, 10, 40, 20}},
                 format);
    // no room above: inside the box
    expect_label({8, 4, 60, 35, 0.5f, 0}, {8, 4, 42, 14}, {{10, 4, 22, 14}, {24, 4, 40, 14}},
                 format);
    // moved into the picture
    expect_label({70, 20, 95, 35, 0.5f, 0}, {46, 10, 80, 20}, {{48, 10, 60, 20}, {62, 10, 78, 20}},
                 format);
    expect_label({-20, -4, 60, 35, 0.5f, 0}, {0, 0, 34, 10}, {{2, 0, 14, 10}, {16, 0, 32, 10}},
                 format);
    // a class without a name, no score
    expect_label({8, 20, 60, 35, 0.5f, 1}, {8, 10, 16, 20}, {{10, 10, 14, 20}}, format, false);
  }
}

TEST(Overlay, BeginsLabelsAtEvenPlacesWhereChromaIsShared) {
  expect_label({9, 21, 61, 35, 0.5f, 0}, {8, 10, 42, 20}, {{10, 10, 22, 20}, {24, 10, 40, 20}},
               "NV12");
  expect_label({9, 21, 61, 35, 0.5f, 0}, {9, 11, 43, 21}, {{11, 11, 23, 21}, {25, 11, 41, 21}},
               "RGB");
}

TEST(Overlay, CutsLabelsThatAreWiderThanThePicture) {
  for (const auto& format : every_format()) {
    TestPicture picture(format, 9, 7);
    Labels labels({{"a long name"}}, true, std::make_unique<Block>(), picture.picture.format);
    auto canvas = picture.canvas();
    auto d = boxes({{1, 1, 5, 5, 1, 0}, {-3, 6, 4, 90, 1, 77}});
    d.scored = true;
    EXPECT_EQ(draw(d, {1, 1, 0}, &labels, &canvas).boxes, 2u);
    EXPECT_EQ(picture.memory[0][2], std::byte{7});
    EXPECT_EQ(picture.memory[0].back(), std::byte{7});
  }
}

}  // namespace overlay_test
}  // namespace weir::draw
