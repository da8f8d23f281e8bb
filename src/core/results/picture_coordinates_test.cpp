// Tests of objects, masks and maps in the source picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/results/picture_coordinates.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::results {
namespace picture_coordinates_test {

// Turns clockwise by an angle about the origin, and scales.
SourceMap turn(double degrees, double scale = 1) {
  const double angle = degrees * std::numbers::pi / 180;
  SourceMap map;
  map.xx = map.yy = scale * std::cos(angle);
  map.yx = scale * std::sin(angle);
  map.xy = -map.yx;
  return map;
}
// One object with a box of 30 x 20 and a mask of 3 x 2.
FrameResults results_with(std::vector<uint8_t> masks) {
  FrameResults out;
  out.objects = {{.box = {10, 40, 40, 60}, .score = 1}};
  out.mask_width = 3, out.mask_height = 2;
  out.masks = std::move(masks);
  return out;
}
const std::vector<uint8_t> kMask{1, 2, 3,  //
                                 4, 5, 6};

FrameResults moved(const SourceMap& map, bool is_rotated = false) {
  FrameResults results = results_with(kMask);
  move_to_picture(map, is_rotated, &results);
  return results;
}
Size size_of(const FrameResults& results) {
  return {results.mask_width, results.mask_height};
}
using Values = std::vector<uint8_t>;

TEST(TurnedMask, StaysWithoutATurn) {
  const FrameResults results = moved(turn(0, 2));
  EXPECT_EQ(results.masks, kMask);
  EXPECT_EQ(size_of(results), (Size{3, 2}));
}

TEST(TurnedMask, TurnsByQuarters) {
  const FrameResults quarter =
      moved(turn(90));  // the first column becomes the first row, from the right
  EXPECT_EQ(size_of(quarter), (Size{2, 3}));
  EXPECT_EQ(quarter.masks, (Values{4, 1,  //
                                   5, 2,  //
                                   6, 3}));
  EXPECT_NEAR(quarter.objects[0].box.x1, -60, 1e-4);
  EXPECT_NEAR(quarter.objects[0].box.y1, 10, 1e-4);
  EXPECT_NEAR(quarter.objects[0].box.x2, -40, 1e-4);
  EXPECT_NEAR(quarter.objects[0].box.y2, 40, 1e-4);
  const FrameResults half = moved(turn(180, 3));
  EXPECT_EQ(size_of(half), (Size{3, 2}));
  EXPECT_EQ(half.masks, (Values{6, 5, 4, 3, 2, 1}));
  const FrameResults back = moved(turn(270));
  EXPECT_EQ(size_of(back), (Size{2, 3}));
  EXPECT_EQ(back.masks, (Values{3, 6, 2, 5, 1, 4}));
}

TEST(TurnedMask, IsMirrored) {
  SourceMap map;
  map.xx = -2, map.x0 = 640;
  EXPECT_EQ(moved(map).masks, (Values{3, 2, 1, 6, 5, 4}));
  map = {};
  map.yy = -1;
  EXPECT_EQ(moved(map).masks, (Values{4, 5, 6, 1, 2, 3}));
}

TEST(TurnedMask, TurnsWithABoxThatTurns) {
  const FrameResults results = moved(turn(90), true);
  EXPECT_EQ(results.masks, kMask);
  EXPECT_NEAR(results.objects[0].rotation, std::numbers::pi / 2, 1e-6);
}

// A square that is turned by 45 degrees fills half of the square around it.
TEST(TurnedMask, FillsADiamondAtFortyFiveDegrees) {
  FrameResults results;
  results.objects = {{.box = {0, 0, 64, 64}, .score = 1}, {.box = {100, 0, 132, 32}, .score = 1}};
  results.mask_width = results.mask_height = 64;
  results.masks.assign(size_t{2} * 64 * 64, 200);
  move_to_picture(turn(45), false, &results);
  EXPECT_EQ(size_of(results), (Size{91, 91})) << "64 times the square root of 2";
  ASSERT_EQ(results.masks.size(), size_t{2} * 91 * 91);
  const auto value = [&](size_t object, size_t column, size_t row) {
    return int{results.masks[(object * 91 + row) * 91 + column]};
  };
  for (const size_t object : {0, 1}) {
    for (const size_t corner : {0, 90}) {
      EXPECT_EQ(value(object, corner, corner), 0);
      EXPECT_EQ(value(object, 90 - corner, corner), 0);
      EXPECT_EQ(value(object, 45, corner == 0 ? 2 : 88), 200) << "within a corner of the diamond";
    }
    EXPECT_EQ(value(object, 45, 45), 200);
    const auto begin = results.masks.begin() + static_cast<ptrdiff_t>(object * 91 * 91);
    const double filled = std::accumulate(begin, begin + 91 * 91, 0.) / 200;
    EXPECT_NEAR(filled / (91 * 91), 0.5, 0.02);
  }
}

// The centre of mass of a mask moves as a point does.
TEST(TurnedMask, ItsMiddleMovesAsAPointDoes) {
  for (const double degrees : {10., 33., 77., 120., 200., 301.}) {
    FrameResults results;
    results.objects = {{.box = {10, 40, 74, 72}, .score = 1}};
    results.mask_width = 64, results.mask_height = 32;
    results.masks.assign(size_t{64} * 32, 0);
    for (size_t y = 4; y < 10; ++y)
      for (size_t x = 40; x < 52; ++x) results.masks[y * 64 + x] = 255;
    results.points = {{10 + 46, 40 + 7, 1}};
    move_to_picture(turn(degrees, 1.5), false, &results);
    const Box& box = results.objects[0].box;
    double sum = 0, x = 0, y = 0;
    for (uint32_t row = 0; row < results.mask_height; ++row)
      for (uint32_t column = 0; column < results.mask_width; ++column) {
        const double weight = results.masks[size_t{row} * results.mask_width + column];
        sum += weight;
        x += weight * (box.x1 + (column + 0.5) * box.width() / results.mask_width);
        y += weight * (box.y1 + (row + 0.5) * box.height() / results.mask_height);
      }
    EXPECT_NEAR(x / sum, results.points[0].x, 0.75) << degrees;
    EXPECT_NEAR(y / sum, results.points[0].y, 0.75) << degrees;
    const double area = sum / 255 * box.area() / (results.mask_width * results.mask_height);
    EXPECT_NEAR(area, 12 * 6 * 1.5 * 1.5, 12) << degrees;
  }
}

TEST(TurnedMask, OfBoxesWithoutAreaOrMapsWithoutAnInverseIsEmpty) {
  SourceMap flat;  // everything on a line
  flat.xx = 1, flat.yx = 1, flat.xy = 1, flat.yy = 1;
  for (const uint8_t value : moved(flat).masks) EXPECT_EQ(value, 0);
  SourceMap none;
  none.xx = none.yy = 0;
  const FrameResults nothing = moved(none);
  EXPECT_EQ(nothing.masks, Values(6, 0));
  FrameResults thin = results_with(kMask);
  thin.objects[0].box = {10, 40, 10, 60};
  move_to_picture(turn(90), false, &thin);
  EXPECT_EQ(thin.masks, Values(6, 0));
  FrameResults not_finite = results_with(kMask);
  not_finite.objects[0].box.x2 = NAN;
  move_to_picture(turn(30), false, &not_finite);
  for (const uint8_t value : not_finite.masks) EXPECT_EQ(value, 0);
}

constexpr float kPi = std::numbers::pi_v<float>;

void expect_box(const Box& box, const Box& expected) {
  EXPECT_NEAR(box.x1, expected.x1, 1e-4);
  EXPECT_NEAR(box.y1, expected.y1, 1e-4);
  EXPECT_NEAR(box.x2, expected.x2, 1e-4);
  EXPECT_NEAR(box.y2, expected.y2, 1e-4);
}

FrameResults results_at(Box box, float rotation = 0) {
  FrameResults out;
  out.objects = {{.box = box, .score = 1, .rotation = rotation}};
  out.points = {{box.x1, box.y2, 1}};
  return out;
}

TEST(ToPicture, UndoesALetterbox) {
  // 1280x720 in 640x640: half the size, 140 rows of border.
  SourceMap map;
  map.xx = map.yy = 2, map.y0 = -280;
  FrameResults results = results_at({10, 150, 20, 170});
  move_to_picture(map, false, &results);
  expect_box(results.objects[0].box, {20, 20, 40, 60});
  EXPECT_EQ(results.points[0], (KeyPoint{20, 60, 1}));
}

TEST(ToPicture, AnUprightBoxOfATurnedPictureStaysUpright) {
  SourceMap map;  // a quarter turn: source x = 100 - y, source y = x
  map.xx = 0, map.xy = -1, map.x0 = 100, map.yx = 1, map.yy = 0;
  FrameResults results = results_at({10, 20, 30, 50});
  move_to_picture(map, false, &results);
  expect_box(results.objects[0].box, {50, 10, 80, 30});
  EXPECT_EQ(results.objects[0].rotation, 0);
}

TEST(ToPicture, ARotatedBoxTurnsWithThePicture) {
  SourceMap map;
  map.xx = 0, map.xy = -1, map.x0 = 100, map.yx = 1, map.yy = 0;
  FrameResults results = results_at({10, 20, 30, 24}, kPi / 6);
  move_to_picture(map, true, &results);
  expect_box(results.objects[0].box, {78 - 10, 20 - 2, 78 + 10, 20 + 2});
  EXPECT_NEAR(results.objects[0].rotation, kPi / 6 + kPi / 2, 1e-6);
}

TEST(ToPicture, CandidatesWithAnAngleHaveTheirCentreAtXY) {
  const detection::Candidate candidate{
      .x = 10, .y = 20, .width = 4, .height = 2, .score = 0.5f, .class_index = -1, .angle = 1};
  expect_box(make_object(candidate, true).box, {8, 19, 12, 21});
  EXPECT_EQ(make_object(candidate, true).rotation, 1);
  expect_box(make_object(candidate, false).box, {10, 20, 14, 22});
  EXPECT_EQ(make_object(candidate, false).class_index, 0);
}

}  // namespace picture_coordinates_test
}  // namespace weir::results
