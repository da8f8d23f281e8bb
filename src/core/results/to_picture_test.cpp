// Tests of the mapping of objects to the source picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/to_picture.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace weir::results {
namespace to_picture_test {

constexpr float kPi = std::numbers::pi_v<float>;

void expect_box(const Box& box, const Box& expected) {
  EXPECT_NEAR(box.x1, expected.x1, 1e-4);
  EXPECT_NEAR(box.y1, expected.y1, 1e-4);
  EXPECT_NEAR(box.x2, expected.x2, 1e-4);
  EXPECT_NEAR(box.y2, expected.y2, 1e-4);
}

Answer answer_of(Box box, float rotation = 0) {
  Answer out;
  out.objects = {{.box = box, .score = 1, .rotation = rotation}};
  out.points = {{box.x1, box.y2, 1}};
  return out;
}

TEST(ToPicture, UndoesALetterbox) {
  // 1280x720 in 640x640: half the size, 140 rows of border.
  SourceMap map;
  map.xx = map.yy = 2, map.y0 = -280;
  Answer answer = answer_of({10, 150, 20, 170});
  move_to_picture(map, false, &answer);
  expect_box(answer.objects[0].box, {20, 20, 40, 60});
  EXPECT_EQ(answer.points[0], (KeyPoint{20, 60, 1}));
}

TEST(ToPicture, AnUprightBoxOfATurnedPictureStaysUpright) {
  SourceMap map;  // a quarter turn: source x = 100 - y, source y = x
  map.xx = 0, map.xy = -1, map.x0 = 100, map.yx = 1, map.yy = 0;
  Answer answer = answer_of({10, 20, 30, 50});
  move_to_picture(map, false, &answer);
  expect_box(answer.objects[0].box, {50, 10, 80, 30});
  EXPECT_EQ(answer.objects[0].rotation, 0);
}

TEST(ToPicture, ARotatedBoxTurnsWithThePicture) {
  SourceMap map;
  map.xx = 0, map.xy = -1, map.x0 = 100, map.yx = 1, map.yy = 0;
  Answer answer = answer_of({10, 20, 30, 24}, kPi / 6);
  move_to_picture(map, true, &answer);
  expect_box(answer.objects[0].box, {78 - 10, 20 - 2, 78 + 10, 20 + 2});
  EXPECT_NEAR(answer.objects[0].rotation, kPi / 6 + kPi / 2, 1e-6);
}

TEST(ToPicture, CandidatesWithAnAngleHaveTheirCentreAtXY) {
  const detection::Candidate candidate{
      .x = 10, .y = 20, .width = 4, .height = 2, .score = 0.5f, .class_index = -1, .angle = 1};
  expect_box(object_of(candidate, true).box, {8, 19, 12, 21});
  EXPECT_EQ(object_of(candidate, true).rotation, 1);
  expect_box(object_of(candidate, false).box, {10, 20, 14, 22});
  EXPECT_EQ(object_of(candidate, false).class_index, 0);
}

}  // namespace to_picture_test
}  // namespace weir::results
