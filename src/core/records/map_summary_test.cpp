// Tests of the parts of classes and the range of depths; the numbers are counted by hand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/map_summary.hpp"

#include <cmath>
#include <limits>

#include "core/records/records_test_support.hpp"

namespace weir::records {
namespace map_summary_test {

// Borrows the memory of the test's frame.
struct ReadFrame : ResultFrame {
  ReadFrame(const std::string& columns, TestFrame frame) : from(std::move(frame)) {
    const Status status = reader_of(columns).read(from.tensors, this);
    EXPECT_TRUE(status) << (status ? "" : status.error().message());
  }
  TestFrame from;
};

// A square network over a picture of 4 x 2 with borders above and below: the grid of 4 x 4 has its
// second and third row in the picture.
SourceMap letterbox() {
  SourceMap map;
  map.width = map.height = 4;
  map.source_width = 4, map.source_height = 2;
  map.xx = map.yy = 1, map.y0 = -1;
  return map;
}

const TestFrame kClasses = TestFrame().bytes("4:4", {9, 9, 9, 9,  //
                                                     0, 0, 0, 3,  //
                                                     0, 3, 7, 7,  //
                                                     9, 9, 9, 9});

TEST(MapSummary, PartsAreOfAllCellsWithoutAMap) {
  const ReadFrame frame("class-map", kClasses);
  const auto parts = parts_of_classes(frame.class_maps[0], std::nullopt);
  ASSERT_EQ(parts.size(), 4u);
  EXPECT_EQ(parts[0].class_index, 0u);
  EXPECT_DOUBLE_EQ(parts[0].part, 4 / 16.0);
  EXPECT_EQ(parts[3].class_index, 9u);
  EXPECT_DOUBLE_EQ(parts[3].part, 8 / 16.0);
}

TEST(MapSummary, PartsLeaveOutTheBordersOfALetterbox) {
  const ReadFrame frame("class-map", kClasses);
  const auto parts = parts_of_classes(frame.class_maps[0], letterbox());
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_DOUBLE_EQ(parts[0].part, 4 / 8.0);
  EXPECT_DOUBLE_EQ(parts[1].part, 2 / 8.0);
  EXPECT_DOUBLE_EQ(parts[2].part, 2 / 8.0);
}

TEST(MapSummary, ClassesMayHaveTwoBytes) {
  const ReadFrame frame("class-map",
                        TestFrame().add<uint16_t>(ElementType::UInt16, "2:1", {300, 65535}));
  const auto parts = parts_of_classes(frame.class_maps[0], std::nullopt);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].class_index, 300u);
  EXPECT_EQ(parts[1].class_index, 65535u);
}

TEST(MapSummary, DepthsHaveARangeAndAMean) {
  const ReadFrame frame("depth", TestFrame().floats("3:2", {1, 2, 3, 4, -5, 7}));
  const auto range = range_of_depths(frame.depths[0], std::nullopt);
  EXPECT_EQ(range.min, -5);
  EXPECT_EQ(range.max, 7);
  EXPECT_DOUBLE_EQ(range.mean, 2);
}

TEST(MapSummary, DepthsThatAreNotFiniteOrNotInThePictureDoNotCount) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const ReadFrame frame("depth", TestFrame().floats("4:4", {99, 99, 99, 99,       //
                                                            1, nan, infinite, 2,  //
                                                            3, 3, 3, 3,           //
                                                            -99, 0, 0, 0}));
  const auto range = range_of_depths(frame.depths[0], letterbox());
  EXPECT_EQ(range.min, 1);
  EXPECT_EQ(range.max, 3);
  EXPECT_DOUBLE_EQ(range.mean, 15.0 / 6);
  const ReadFrame none("depth", TestFrame().floats("1:1", {nan}));
  EXPECT_EQ(range_of_depths(none.depths[0], std::nullopt).max, 0);
}

}  // namespace map_summary_test
}  // namespace weir::records
