// The source map through cuts, scaling and transforms.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transformed_source_map.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace weir::transform {
namespace transformed_source_map_test {

SourceMap through(Mode mode, const char* option, const SourceMap& in) {
  const auto operation = parse(mode, option);
  EXPECT_TRUE(operation) << option;
  return transform_source_map(*operation, in);
}

void expect_point(Point point, double x, double y) {
  EXPECT_DOUBLE_EQ(point.x, x);
  EXPECT_DOUBLE_EQ(point.y, y);
}

TEST(SourceMap, OfAnUnchangedPictureIsTheIdentity) {
  const auto map = picture_as_it_is(640, 480, false);
  expect_point(map.to_source({3.5, 7.25}), 3.5, 7.25);
  EXPECT_EQ(map.x_dimension, 1);
  EXPECT_EQ(map.y_dimension, 2);
  EXPECT_EQ(picture_as_it_is(640, 480, true).x_dimension, 0);
  EXPECT_EQ(picture_as_it_is(640, 480, true).y_dimension, 1);
}

TEST(SourceMap, OfAPartIsComposedWithTheWhole) {
  // 640x480 letterboxed into 320x320: scaled by one half, with 40 rows of border above.
  const auto boxed = picture_as_it_is(640, 480, false).of_part(2, 0, 2, -80, 320, 320);
  expect_point(boxed.to_source({0, 40}), 0, 0);
  expect_point(boxed.to_source({320, 280}), 640, 480);
  // From there the square at (100, 60), 50 pixels wide, enlarged to 100.
  const auto cut = boxed.of_part(0.5, 100, 0.5, 60, 100, 100);
  expect_point(cut.to_source({0, 0}), 200, 40);
  expect_point(cut.to_source({100, 100}), 300, 140);
  EXPECT_EQ(cut.width, 100u);
  EXPECT_EQ(cut.source_width, 640u);
}

TEST(SourceMap, IsInvertibleAlsoWhenTransposed) {
  SourceMap turned = picture_as_it_is(100, 100, false);
  const double c = std::cos(0.7), s = std::sin(0.7);
  turned.xx = 2 * c, turned.xy = -3 * s, turned.x0 = 11;
  turned.yx = 2 * s, turned.yy = 3 * c, turned.y0 = -5;
  for (const Point point : {Point{0, 0}, Point{10.5, 3}, Point{-4, 77}}) {
    const Point back = turned.to_tensor(turned.to_source(point));
    EXPECT_NEAR(back.x, point.x, 1e-12);
    EXPECT_NEAR(back.y, point.y, 1e-12);
  }
  SourceMap flat = turned;
  flat.xx = flat.xy = 0;
  EXPECT_FALSE(std::isfinite(flat.to_tensor({1, 1}).x));
}

TEST(SourceMap, FollowsTheDimensionsOfATransposition) {
  const auto packed = picture_as_it_is(640, 480, false);  // C:W:H
  const auto planes = through(Mode::Transpose, "1:2:0:3", packed);
  EXPECT_EQ(planes.x_dimension, 0);
  EXPECT_EQ(planes.y_dimension, 1);
  const auto moved_channel = through(Mode::Dimchg, "0:2", packed);
  EXPECT_EQ(moved_channel.x_dimension, 0);
  EXPECT_EQ(moved_channel.y_dimension, 1);
  const auto back = through(Mode::Dimchg, "2:0", moved_channel);
  EXPECT_EQ(back.x_dimension, 1);
  EXPECT_EQ(back.y_dimension, 2);
  EXPECT_EQ(through(Mode::Dimchg, "3:0", packed).y_dimension, 3);
  EXPECT_EQ(through(Mode::Dimchg, "1:1", packed).x_dimension, 1);
}

TEST(SourceMap, FollowsAPadding) {
  const auto planar = through(Mode::Padding, "left:8,right:2,top:3,bottom:4,front:9",
                              picture_as_it_is(640, 480, true));
  expect_point(planar.to_source({8, 3}), 0, 0);
  EXPECT_EQ(planar.width, 650u);
  EXPECT_EQ(planar.height, 487u);
  const auto packed =
      through(Mode::Padding, "left:5,top:8,back:7", picture_as_it_is(640, 480, false));
  expect_point(packed.to_source({8, 0}), 0, 0);
  EXPECT_EQ(packed.width, 648u);
  EXPECT_EQ(packed.height, 487u);
}

TEST(SourceMap, IsUnchangedIfOnlyValuesChange) {
  const auto map = picture_as_it_is(640, 480, false);
  for (const auto& [mode, option] : {std::pair{Mode::Typecast, "float32"},
                                     {Mode::Clamp, "0:1"},
                                     {Mode::Arithmetic, "add:1"},
                                     {Mode::Stand, "default"}})
    EXPECT_EQ(through(mode, option, map).x_dimension, 1);
}

}  // namespace transformed_source_map_test
}  // namespace weir::transform
