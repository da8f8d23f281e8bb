// Tests of dots, bones and names, pixel by pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/skeleton.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/draw/glyphs.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::draw {
namespace skeleton_test {

using Rows = std::vector<std::string>;

// A frame of its own, as rows of text: '#' white, '.' transparent, '?' anything else.
struct Drawing {
  Drawing(uint32_t width, uint32_t height)
      : size{width, height}, bytes(draw::rgba_bytes(size)), frame(bytes, size) {
    frame.clear();
  }
  Rows rows() const {
    Rows out;
    for (size_t y = 0; y < size.height; ++y) {
      out.emplace_back();
      for (size_t x = 0; x < size.width; ++x) {
        const Rgba pixel = reinterpret_cast<const Rgba*>(bytes.data())[y * size.width + x];
        out.back() += pixel == kWhite ? '#' : pixel == kTransparent ? '.' : '?';
      }
    }
    return out;
  }
  Size size;
  std::vector<std::byte> bytes;
  RgbaFrame frame;
};

TEST(DrawDot, IsTheListedPixels) {
  Drawing drawing(11, 11);
  draw_dot(drawing.frame, {5, 5}, kWhite);
  EXPECT_EQ(drawing.rows(), (Rows{"...........",  //
                                  ".....#.....",  //
                                  "....###....",  //
                                  "...#####...",  //
                                  "..#######..",  //
                                  ".####.####.",  //
                                  "..#######..",  //
                                  "...#####...",  //
                                  "....###....",  //
                                  ".....#.....",  //
                                  "..........."}));
}

TEST(DrawDot, IsCutAtTheEdges) {
  Drawing drawing(4, 3);
  draw_dot(drawing.frame, {0, 0}, kWhite);
  EXPECT_EQ(drawing.rows(), (Rows{".###", "####", "###."}));
  Drawing outside(4, 3);
  for (const PixelPoint at : {PixelPoint{-9, 0}, {20, 1}, {1, -9}, {1, 20}})
    draw_dot(outside.frame, at, kWhite);
  EXPECT_EQ(outside.rows(), Rows(3, "...."));
}

// The line is in rows 5 and 6, where it fills the gaps between and in the dots.
TEST(DrawSkeleton, ConnectsTwoJoints) {
  const Rows expected{"................................",  //
                      ".........#............#.........",  //
                      "........###..........###........",  //
                      ".......#####........#####.......",  //
                      "......#######......#######......",  //
                      ".....######################.....",  //
                      "......####################......",  //
                      ".......#####........#####.......",  //
                      "........###..........###........",  //
                      ".........#............#.........",  //
                      "................................"};
  for (const bool swapped : {false, true}) {
    Drawing drawing(32, 11);
    const Joint left = PixelPoint{9, 5}, right = PixelPoint{22, 5};
    const std::vector<Joint> joints = swapped ? std::vector{right, left} : std::vector{left, right};
    draw_skeleton(drawing.frame, joints, std::vector<Bone>{{0, 1}}, kWhite);
    EXPECT_EQ(drawing.rows(), expected) << swapped;
  }
}

TEST(DrawSkeleton, LeavesOutBonesWithoutAJoint) {
  Drawing drawing(20, 20);
  const std::vector<Joint> joints{PixelPoint{5, 5}, std::nullopt, PixelPoint{15, 15}};
  draw_skeleton(drawing.frame, joints, std::vector<Bone>{{0, 1}, {1, 2}, {1, 1}}, kWhite);
  EXPECT_EQ(drawing.rows(), Rows(20, std::string(20, '.')));
}

TEST(DrawSkeleton, DrawsAJointThatIsConnectedWithItself) {
  Drawing bone(9, 9), dot(9, 9);
  const std::vector<Joint> joints{PixelPoint{4, 4}};
  draw_skeleton(bone.frame, joints, std::vector<Bone>{{0, 0}}, kWhite);
  draw_dot(dot.frame, {4, 4}, kWhite);
  dot.frame.set(4, 4, kWhite);
  EXPECT_EQ(bone.rows(), dot.rows());
}

TEST(DrawNames, WritesCompleteCells14RowsAboveTheJoint) {
  Drawing drawing(20, 30);
  for (int64_t y = 0; y < 30; ++y)
    for (int64_t x = 0; x < 20; ++x) drawing.frame.set(x, y, kWhite);
  const std::vector<Joint> joints{PixelPoint{1, 20}};
  draw_names(drawing.frame, joints, std::vector<std::string>{"ab"}, kWhite);
  Rows expected(30, std::string(20, '#'));
  for (const auto& [character, left] : {std::pair{'a', 1}, {'b', 10}})
    for (int y = 0; y < kGlyphHeight; ++y)
      for (int x = 0; x < kGlyphWidth; ++x)
        if (!(get_glyph(character)[y] & 0x80 >> x)) expected[6 + y][left + x] = '.';
  EXPECT_EQ(drawing.rows(), expected);
}

TEST(DrawNames, StaysInTheFrame) {
  const auto name_at = [](PixelPoint at, uint32_t width = 20, uint32_t height = 30) {
    Drawing drawing(width, height);
    const std::vector<Joint> joints{at, std::nullopt};
    draw_names(drawing.frame, joints, std::vector<std::string>{"m", "never"}, kWhite);
    return drawing.rows();
  };
  EXPECT_EQ(name_at({3, 5}), name_at({3, 14})) << "not above the frame";
  EXPECT_NE(name_at({12, 5}), Rows(30, std::string(20, '.')));
  EXPECT_EQ(name_at({13, 5}), Rows(30, std::string(20, '.'))) << "no room for a character";
  const auto low = name_at({3, 5}, 20, 8);  // the frame is lower than a cell
  const auto all = name_at({3, 5});
  EXPECT_EQ(low, Rows(all.begin(), all.begin() + 8));
}

}  // namespace skeleton_test
}  // namespace weir::draw
