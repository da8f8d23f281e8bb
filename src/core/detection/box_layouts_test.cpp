// Tests of detection heads: rows with values whose boxes follow by hand, thresholds, and numbers
// that are not finite.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/detection/best_class.hpp"
#include "core/detection/box_layouts.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {
namespace box_layouts_test {

constexpr Size kPicture{640, 320};
const float kNan = std::nanf(""), kInfinity = INFINITY;

TEST(BestClass, IsTheFirstGreatestNumber) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> value(-3, 3);
  for (size_t size = 0; size < 40; ++size) {
    std::vector<float> scores(size);
    for (float& score : scores) score = static_cast<float>(value(random));
    if (size > 2) scores[size / 2] = kNan;
    float best = -kInfinity;
    int32_t first = 0;
    for (size_t i = 0; i < size; ++i)
      if (scores[i] > best) best = scores[i], first = static_cast<int32_t>(i);
    EXPECT_EQ(best_score(scores), best) << size;
    EXPECT_EQ(class_with(scores, best), first) << size;
  }
}

Candidates postprocessed(std::vector<float> boxes, std::vector<float> classes,
                         std::vector<float> scores, float count, float threshold = 0.5f) {
  return decode({.boxes = boxes, .classes = classes, .scores = scores, .count = count}, threshold,
                kPicture);
}

TEST(SsdPostprocessed, ScalesAndClampsTheBox) {
  const auto found = postprocessed({0.25f, 0.5f, 0.75f, 1.5f}, {7}, {0.5f}, 1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (Candidate{.x = 320,
                                 .y = 80,
                                 .width = 320,
                                 .height = 160,
                                 .score = 0.5f,
                                 .class_index = 7,
                                 .row = 0}));
}

TEST(SsdPostprocessed, ReadsAsManyRowsAsTheCountDeclares) {
  const std::vector<float> boxes{0, 0, 1, 1, 0, 0, 1, 1}, classes{0, 1}, scores{1, 1};
  const std::pair<float, size_t> counts[] = {{0, 0},     {1, 1},  {2, 2},         {3, 2},
                                             {1e30f, 2}, {-1, 0}, {kInfinity, 2}, {kNan, 0}};
  for (const auto& [count, rows] : counts)
    EXPECT_EQ(postprocessed(boxes, classes, scores, count).size(), rows) << count;
}

TEST(SsdPostprocessed, LeavesOutRowsThatAreNotFinite) {
  for (const float bad : {kNan, kInfinity, -kInfinity}) {
    EXPECT_TRUE(postprocessed({0, bad, 1, 1}, {0}, {1}, 1).empty());
    EXPECT_TRUE(postprocessed({0, 0, 1, 1}, {bad}, {1}, 1).empty());
  }
  EXPECT_TRUE(postprocessed({0, 0, 1, 1}, {0}, {kNan}, 1).empty());
  EXPECT_TRUE(postprocessed({0, 0, 1, 1}, {0}, {kInfinity}, 1).empty());
  EXPECT_TRUE(postprocessed({0, 0, 1, 1}, {0}, {0.49f}, 1).empty());
}

TEST(YoloV5, MultipliesTheBestClassByTheObjectness) {
  const std::vector<float> rows{0.5f, 0.5f, 0.25f, 0.5f, 0.5f,  0.25f, 0.75f,  //
                                0.5f, 0.5f, 0.25f, 0.5f, 0.25f, 1,     0.5f};
  const auto found = decode_yolov5(rows, 2, 0.25f, YoloUnit::Picture, kPicture);
  ASSERT_EQ(found.size(), 1u) << "0.25 is not above 0.25";
  EXPECT_EQ(found[0], (Candidate{.x = 240,
                                 .y = 80,
                                 .width = 160,
                                 .height = 160,
                                 .score = 0.375f,
                                 .class_index = 1,
                                 .row = 0}));
}

TEST(YoloV5, TakesPixelsAsTheyAre) {
  const std::vector<float> row{100, 50, 20, 10, 1, 1};
  const auto found = decode_yolov5(row, 1, 0.25f, YoloUnit::Pixels, kPicture);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].x, 90);
  EXPECT_EQ(found[0].y, 45);
  EXPECT_EQ(found[0].width, 20);
}

TEST(YoloV5, LeavesOutRowsThatAreNotFinite) {
  for (const float bad : {kNan, kInfinity, -kInfinity})
    for (size_t i = 0; i < 4; ++i) {
      std::vector<float> row{0.5f, 0.5f, 0.5f, 0.5f, 1, 1};
      row[i] = bad;
      EXPECT_TRUE(decode_yolov5(row, 1, 0.25f, YoloUnit::Picture, kPicture).empty()) << i;
      EXPECT_TRUE(
          decode_yolov8(std::span(row).first(5), 1, 0.25f, YoloUnit::Picture, kPicture).empty());
    }
  EXPECT_TRUE(
      decode_yolov5(std::vector<float>{0, 0, 1, 1, kNan, 1}, 1, 0.25f, YoloUnit::Picture, kPicture)
          .empty());
}

// Scores that are not numbers are less than every number, and a negative objectness turns that
// around.
TEST(YoloV5, LeavesOutProbabilitiesThatAreNotFinite) {
  const std::vector<std::pair<float, float>> pairs{
      {-1, kNan}, {1, kInfinity}, {kInfinity, 1}, {-1, -kInfinity}};
  for (const auto& [objectness, score] : pairs) {
    const std::vector<float> row{0.5f, 0.5f, 0.5f, 0.5f, objectness, score};
    EXPECT_TRUE(decode_yolov5(row, 1, 0.25f, YoloUnit::Picture, kPicture).empty()) << objectness;
  }
  const std::vector<float> row{0.5f, 0.5f, 0.5f, 0.5f, kInfinity, 0};
  EXPECT_TRUE(
      decode_yolov8(std::span(row).first(5), 1, 0.25f, YoloUnit::Picture, kPicture).empty());
  EXPECT_TRUE(decode_yolov8_obb(row, 1, 0.25f, YoloUnit::Picture, kPicture).empty());
}

TEST(YoloRows, AreThoseOfThreeGrids) {
  EXPECT_EQ(yolo_rows({640, 640}, 3), 25200u);
  EXPECT_EQ(yolo_rows({640, 640}, 1), 8400u);
  EXPECT_EQ(yolo_rows({320, 320}, 3), 6300u);
  EXPECT_EQ(yolo_rows({7, 640}, 1), 0u);
}

TEST(YoloV8, TakesTheBestClass) {
  const std::vector<float> rows{0.5f, 0.5f, 0.25f, 0.5f, 0.25f, 0.5f,  //
                                0.5f, 0.5f, 0.25f, 0.5f, 0.25f, 0.25f};
  const auto found = decode_yolov8(rows, 2, 0.25f, YoloUnit::Picture, kPicture);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (Candidate{.x = 240,
                                 .y = 80,
                                 .width = 160,
                                 .height = 160,
                                 .score = 0.5f,
                                 .class_index = 1,
                                 .row = 0}));
}

TEST(YoloV8, OrientedBoxesHaveTheirCentreAndAngle) {
  const std::vector<float> row{0.5f, 0.5f, 0.25f, 0.5f, 0.25f, 0.5f, 1.5f};
  const auto found = decode_yolov8_obb(row, 2, 0.25f, YoloUnit::Picture, kPicture);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (Candidate{.x = 320,
                                 .y = 160,
                                 .width = 160,
                                 .height = 160,
                                 .score = 0.5f,
                                 .class_index = 1,
                                 .row = 0,
                                 .angle = 1.5f}));
  auto bad = row;
  bad.back() = kNan;
  EXPECT_TRUE(decode_yolov8_obb(bad, 2, 0.25f, YoloUnit::Picture, kPicture).empty());
}

TEST(YoloV10, EndsAtTheFirstLowScore) {
  const std::vector<float> rows{0.25f, 0.25f, 0.5f, 0.75f, 0.5f,   3,  //
                                0,     0,     1,    1,     0.125f, 1,  //
                                0,     0,     1,    1,     0.5f,   2};
  const auto found = decode_yolov10(rows, 0.25f, kPicture);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (Candidate{.x = 160,
                                 .y = 80,
                                 .width = 160,
                                 .height = 160,
                                 .score = 0.5f,
                                 .class_index = 3,
                                 .row = 0}));
}

TEST(YoloV10, LeavesOutRowsThatAreNotFinite) {
  for (size_t i = 0; i < kYolov10Row; ++i)
    for (const float bad : {kNan, kInfinity}) {
      std::vector<float> rows{0, 0, 1, 1, 0.5f, 0, 0, 0, 1, 1, 0.5f, 1};
      rows[i] = bad;
      const auto found = decode_yolov10(rows, 0.25f, kPicture);
      ASSERT_EQ(found.size(), 1u) << i;
      EXPECT_EQ(found[0].row, 1u);
    }
}

TEST(OpenvinoRecords, EndAtANegativePicture) {
  const std::vector<float> records{0,  1, 0.75f,  0.25f, 0.25f, 0.5f, 0.75f,  //
                                   0,  1, 0.875f, 0.25f, 0.25f, 0.5f, 0.75f,  //
                                   -1, 0, 1,      0,     0,     1,    1,      //
                                   0,  1, 1,      0,     0,     1,    1};
  const auto found = decode_openvino(records, 0.8f, kPicture);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (Candidate{.x = 160,
                                 .y = 80,
                                 .width = 160,
                                 .height = 160,
                                 .score = 0.875f,
                                 .class_index = 1,
                                 .row = 1}));
  auto bad = records;
  bad[10] = kNan;
  EXPECT_TRUE(decode_openvino(bad, 0.8f, kPicture).empty());
}

}  // namespace box_layouts_test
}  // namespace weir::detection
