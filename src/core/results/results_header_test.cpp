// Tests of weir/results.h and weir/results.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/results.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace results_header_test {

TEST(ResultColumns, AreFoundByName) {
  const auto columns = result_columns("x1,y1,x2,y2,score,class,track,parent,rotation,xys:17", 0);
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->kind, uint32_t{WEIR_RESULT_ROWS});
  EXPECT_EQ(columns->length, 9u + 3 * 17);
  EXPECT_EQ(columns->box, 0);
  EXPECT_EQ(columns->score, 4);
  EXPECT_EQ(columns->class_index, 5);
  EXPECT_EQ(columns->track, 6);
  EXPECT_EQ(columns->parent, 7);
  EXPECT_EQ(columns->rotation, 8);
  EXPECT_EQ(columns->points, 9);
  EXPECT_EQ(columns->n_points, 17u);
  EXPECT_EQ(columns->point_length, 3u);
}

TEST(ResultColumns, MayStandInAnyOrderWithUnknownOnesBetween) {
  const auto columns = result_columns("speed,embedding:128,score,xy:5,x1,y1,x2,y2", 0);
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->score, 129);
  EXPECT_EQ(columns->points, 130);
  EXPECT_EQ(columns->point_length, 2u);
  EXPECT_EQ(columns->box, 140);
  EXPECT_EQ(columns->length, 144u);
  EXPECT_EQ(columns->class_index, -1);
}

TEST(ResultColumns, OfEachTensorAreSeparatedBySemicolons) {
  const char* text = "score,class;scores;;masks;class-map;depth;text";
  const uint32_t kinds[] = {WEIR_RESULT_ROWS,  WEIR_RESULT_SCORES,    WEIR_RESULT_NONE,
                            WEIR_RESULT_MASKS, WEIR_RESULT_CLASS_MAP, WEIR_RESULT_DEPTH,
                            WEIR_RESULT_TEXT,  WEIR_RESULT_NONE};
  for (uint32_t i = 0; i < std::size(kinds); ++i) {
    const auto columns = result_columns(text, i);
    ASSERT_TRUE(columns) << i;
    EXPECT_EQ(columns->kind, kinds[i]) << i;
  }
}

TEST(ResultColumns, MissingTextHasNoResults) {
  weir_result_columns columns;
  ASSERT_TRUE(weir_results_parse(nullptr, 0, &columns));
  EXPECT_EQ(columns.kind, uint32_t{WEIR_RESULT_NONE});
}

TEST(ResultColumns, RejectWhatNoWriterMakes) {
  for (const char* text : {"score,score",
                           "class,class",
                           "x1,y1,x2",
                           "x1,y1,score,x2,y2",
                           "y1,x1,x2,y2",
                           "y1",
                           "x1,y1,x2,y2,x1,y1,x2,y2",
                           "score,",
                           ",score",
                           "score,,class",
                           "xy",
                           "xys:0",
                           "xys:",
                           "xys:-1",
                           "xys:a",
                           "a:65537",
                           "xys:21846",
                           "xy:2,xys:3",
                           ":3",
                           "xys:99999999999999999999"})
    EXPECT_FALSE(result_columns(text, 0)) << text;
}

TEST(ResultColumns, FaultsOfOtherTensorsDoNotMatter) {
  EXPECT_TRUE(result_columns("score,class;score,score", 0));
  EXPECT_FALSE(result_columns("score,class;score,score", 1));
}

TEST(ResultColumns, ARowHasAtMost65536Numbers) {
  EXPECT_TRUE(result_columns("a:65536", 0));
  EXPECT_FALSE(result_columns("a:65536,b", 0));
}

TEST(ResultRow, ReadsColumns) {
  const auto columns = result_columns("x1,y1,x2,y2,score,class,track,parent,rotation,xys:1", 0);
  const float numbers[] = {1, 2, 3, 4, 0.5f, 7, 16777215, 2, 0.25f, 10, 20, 0.75f};
  const ResultRow row(*columns, numbers);
  EXPECT_EQ(row.box(), (Box{1, 2, 3, 4}));
  EXPECT_EQ(row.score(), 0.5f);
  EXPECT_EQ(row.class_index(), 7);
  EXPECT_EQ(row.track(), 16777215u);
  EXPECT_EQ(row.parent(), 2);
  EXPECT_EQ(row.rotation(), 0.25f);
  EXPECT_EQ(row.x(0), 10);
  EXPECT_EQ(row.y(0), 20);
  EXPECT_EQ(row.point_score(0), 0.75f);
  EXPECT_FALSE(row.is_background());
}

TEST(ResultRow, AbsentColumnsAreNeutral) {
  const auto columns = result_columns("other", 0);
  const float number = 3;
  const ResultRow row(*columns, &number);
  EXPECT_FALSE(row.has_box());
  EXPECT_EQ(row.score(), 1);
  EXPECT_EQ(row.class_index(), 0);
  EXPECT_EQ(row.track(), 0u);
  EXPECT_EQ(row.parent(), -1);
  EXPECT_EQ(row.n_points(), 0u);
}

TEST(ResultRow, NumbersThatAreNotIntegersDoNoHarm) {
  const auto columns = result_columns("score,class,track,parent", 0);
  for (const float odd : {NAN, INFINITY, -INFINITY, 1e30f}) {
    const float numbers[] = {odd, odd, odd, odd};
    const ResultRow row(*columns, numbers);
    EXPECT_EQ(row.class_index(), 0);
    EXPECT_EQ(row.track(), 0u);
    EXPECT_EQ(row.parent(), -1);
  }
  const float background[] = {NAN, 0, 0, 0};
  EXPECT_TRUE(ResultRow(*columns, background).is_background());
}

}  // namespace results_header_test
}  // namespace weir
