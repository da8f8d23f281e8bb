// Tests of what a frame of results looks like when it is drawn.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/drawn_results.hpp"

#include <algorithm>
#include <cmath>

#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace drawn_results_test {

draw::Detections drawn(const std::string& columns, const TestFrame& frame,
                       const std::vector<SourceMap>& maps = {}) {
  const ResultReader reader = reader_of(columns, "detector");
  ResultFrame read;
  const Status status = reader.read(frame.tensors, &read);
  EXPECT_TRUE(status) << (status ? "" : status.error().message());
  return drawn_results(reader, read, maps);
}

SourceMap picture_of(uint32_t width, uint32_t height) {
  return picture_as_it_is(width, height, false);
}

TEST(DrawnResults, HaveBoxTrackRotationAndPoints) {
  const auto d =
      drawn("x1,y1,x2,y2,score,class,track,parent,rotation,xys:2",
            TestFrame().floats("15:2", {1, 2, 3, 4, 0.5f, 6, 7, -1, 0.25f, 9, 8, 1, 5, 6, 0.5f,  //
                                        0, 0, 0, 0, 0,    0, 0, 0,  0,     0, 0, 0, 0, 0, 0}));
  ASSERT_EQ(d.rows.size(), 1u);  // the second row is background
  const auto& row = d.rows[0];
  EXPECT_EQ(row.x1, 1);
  EXPECT_EQ(row.y2, 4);
  EXPECT_EQ(row.class_index, 6u);
  EXPECT_EQ(row.track, 7u);
  EXPECT_EQ(row.rotation, 0.25f);
  EXPECT_FALSE(row.is_label);
  EXPECT_TRUE(d.scored);
  ASSERT_EQ(d.points_per_row, 2u);
  EXPECT_EQ(d.points[1].y, 6);
  EXPECT_EQ(d.point_scores, (std::vector<float>{1, 0.5f}));
}

TEST(DrawnResults, RowsWithoutABoxAreLabelsOfThePictureOrOfTheirParent) {
  const auto d = drawn("x1,y1,x2,y2,score,class;score,class,track,parent",
                       TestFrame()
                           .floats("6:1", {10, 20, 30, 40, 0.5f, 1})
                           .floats("4:2", {0.9f, 3, 0, 0,  //
                                           0.8f, 4, 0, -1}),
                       {picture_of(640, 480), picture_of(640, 480)});
  ASSERT_EQ(d.rows.size(), 3u);
  EXPECT_TRUE(d.rows[1].is_label);
  EXPECT_EQ(d.rows[1].x1, 10);
  EXPECT_EQ(d.rows[1].y2, 40);
  EXPECT_TRUE(d.rows[2].is_label);
  EXPECT_EQ(d.rows[2].x2, 640);
  EXPECT_EQ(d.rows[2].y2, 480);
}

TEST(DrawnResults, CarryMasksAndTexts) {
  const auto d =
      drawn("x1,y1,x2,y2,score,class;masks;text", TestFrame()
                                                      .floats("6:1", {10, 20, 30, 40, 0.5f, 1})
                                                      .bytes("2:1:1", {255, 7})
                                                      .texts(5, {"EXIT"}));
  ASSERT_EQ(d.rows.size(), 1u);
  ASSERT_EQ(d.masks.size(), 1u);
  EXPECT_EQ(d.masks[0].values, (std::vector<uint8_t>{255, 7}));
  ASSERT_EQ(d.rows[0].text, 0);
  EXPECT_EQ(d.texts[0], "EXIT");
}

TEST(DrawnResults, ATextIsTheLabelOfTheBoxThatItWasReadIn) {
  const auto d = drawn("x1,y1,x2,y2,score,class;score,parent;text",
                       TestFrame()
                           .floats("6:2", {10, 20, 30, 40, 0.5f, 1, 50, 60, 70, 80, 0.6f, 0})
                           .floats("2:3", {0.9f, 1, 0.8f, 1, 0.7f, -1})
                           .texts(4, {"EXIT", "DOOR", "SIGN"}),
                       {picture_of(640, 480)});
  // Two boxes, and the texts that have no box of their own: a second one of a box, and one of none.
  ASSERT_EQ(d.rows.size(), 4u);
  EXPECT_EQ(d.rows[0].text, -1);
  ASSERT_EQ(d.rows[1].text, 0);
  EXPECT_EQ(d.texts[0], "EXIT");
  EXPECT_EQ(d.rows[1].score, 0.9f);
  EXPECT_FALSE(d.rows[1].is_label);
  EXPECT_TRUE(d.rows[2].is_label);
  EXPECT_EQ(d.texts[static_cast<size_t>(d.rows[2].text)], "DOOR");
  EXPECT_EQ(d.rows[3].x2, 640);
  EXPECT_EQ(d.left_out.beyond_limit, 0u);
}

TEST(DrawnResults, ClassMapsLieWhereTheirSourceMapPlacesThem) {
  SourceMap map = picture_of(640, 480);  // a grid of 4 x 2 over the lower half
  map.width = 4, map.height = 2;
  map.xx = 160, map.yy = 120, map.y0 = 240;
  const auto d = drawn("score,class;class-map",
                       TestFrame().floats("2:1", {0, 0}).bytes("4:2", {0, 1, 2, 3, 4, 5, 6, 7}),
                       {picture_of(640, 480), map});
  ASSERT_EQ(d.class_maps.size(), 1u);
  EXPECT_EQ(d.class_maps[0].y1, 240);
  EXPECT_EQ(d.class_maps[0].x2, 640);
  EXPECT_EQ(d.class_maps[0].y2, 480);
  EXPECT_EQ(d.class_maps[0].classes[5], 5);
}

TEST(DrawnResults, DepthsBecomeLevelsOfTheirRange) {
  const auto d = drawn("depth", TestFrame().floats("4:1", {2, 4, 3, NAN}), {picture_of(640, 480)});
  ASSERT_EQ(d.class_maps.size(), 1u);
  EXPECT_TRUE(d.class_maps[0].is_depth);
  EXPECT_EQ(d.class_maps[0].classes, (std::vector<uint16_t>{0, 255, 128, 0}));
  const auto flat = drawn("depth", TestFrame().floats("2:1", {7, 7}));
  EXPECT_EQ(flat.class_maps[0].classes, (std::vector<uint16_t>{0, 0}));
}

TEST(DrawnResults, ClassMapsTurnWithTheirSourceMap) {
  SourceMap map = picture_of(480, 640);  // a quarter turn: source x = 480 - 240 y, y = 160 x
  map.width = 4, map.height = 2;
  map.xx = 0, map.xy = -240, map.x0 = 480, map.yx = 160, map.yy = 0;
  const auto d = drawn("score,class;class-map",
                       TestFrame().floats("2:1", {0, 0}).bytes("4:2", {0, 1, 2, 3, 4, 5, 6, 7}),
                       {picture_of(480, 640), map});
  ASSERT_EQ(d.class_maps.size(), 1u);
  const draw::ClassMap& turned = d.class_maps[0];
  EXPECT_EQ(turned.x1, 0);
  EXPECT_EQ(turned.x2, 480);
  EXPECT_EQ(turned.y1, 0);
  EXPECT_EQ(turned.y2, 640);
  ASSERT_EQ(turned.width, 2u);
  ASSERT_EQ(turned.height, 4u);
  EXPECT_EQ(turned.classes, (std::vector<uint16_t>{4, 0, 5, 1, 6, 2, 7, 3}));
}

TEST(DrawnResults, TiltedClassMapsHaveBackgroundAroundThem) {
  SourceMap map = picture_of(640, 480);  // an eighth of a turn
  map.width = map.height = 40;
  map.xx = map.yy = 4 * std::sqrt(0.5), map.yx = map.xx, map.xy = -map.xx;
  map.x0 = 320;
  const auto d =
      drawn("score,class;class-map",
            TestFrame().floats("2:1", {0, 0}).bytes("40:40", std::vector<uint8_t>(1600, 3)),
            {picture_of(640, 480), map});
  const draw::ClassMap& turned = d.class_maps.at(0);
  ASSERT_EQ(turned.width, 57u) << "40 times the square root of 2";
  const auto count = std::count(turned.classes.begin(), turned.classes.end(), 3);
  EXPECT_EQ(turned.classes[0], 0);
  EXPECT_EQ(turned.classes[28 * 57 + 28], 3);
  EXPECT_NEAR(static_cast<double>(count) / (57 * 57), 0.5, 0.02);
}

}  // namespace drawn_results_test
}  // namespace weir::records
