// Reads detections from tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/detections.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "says.hpp"

namespace weir::draw {
namespace detections_test {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Result<Detections> read(uint32_t k, std::vector<float> numbers,
                        const std::vector<SourceMap>& maps = {}) {
  const TensorSpec spec{ElementType::Float32, {k, static_cast<uint32_t>(numbers.size() / k)}, ""};
  EXPECT_TRUE(check_detections(spec));
  return read_detections(spec, std::as_bytes(std::span(numbers)), maps);
}

TEST(Detections, HaveWhatTheirRowsHave) {
  const auto four = *read(4, {1, 2, 3, 4.5f});
  ASSERT_EQ(four.rows.size(), 1u);
  EXPECT_EQ(four.rows[0].x1, 1);
  EXPECT_EQ(four.rows[0].y2, 4.5);
  EXPECT_FALSE(four.scored);
  EXPECT_GT(four.rows[0].score, 0);
  const auto five = *read(5, {1, 2, 3, 4, 0.5f, 5, 6, 7, 8, 0.25f});
  ASSERT_EQ(five.rows.size(), 2u);
  EXPECT_TRUE(five.scored);
  EXPECT_EQ(five.rows[1].score, 0.25f);
  EXPECT_EQ(five.rows[1].class_index, 0u);
  const auto ten = *read(10, {1, 2, 3, 4, 0.5f, 17, 1, 2, 3, 4});
  EXPECT_EQ(ten.rows[0].class_index, 17u);
  ASSERT_EQ(ten.points.size(), 2u);
  EXPECT_EQ(ten.points_per_row, 2u);
  EXPECT_EQ(ten.points[1].y, 4);
}

TEST(Detections, OfZerosIsBackground) {
  EXPECT_TRUE(read(6, {0, 0, 0, 0, 0, 0})->rows.empty());
  EXPECT_EQ(read(6, {1, 1, 2, 2, -1, 0})->left_out.background, 1u);
  EXPECT_EQ(read(4, {0, 0, 0, 0})->left_out.without_area, 1u);
}

TEST(Detections, CountWhatCannotBeDrawn) {
  for (size_t i = 0; i < 6; ++i)
    for (const float odd : {kNan, kInf, -kInf}) {
      std::vector<float> row{1, 2, 3, 4, 0.5f, 0};
      row[i] = odd;
      if (i == 4 && odd == -kInf) continue;  // a score below 0 is background
      const auto read_row = read(6, row);
      EXPECT_TRUE(read_row->rows.empty()) << i << " " << odd;
      EXPECT_EQ(read_row->left_out.not_finite, 1u) << i << " " << odd;
    }
  for (const auto& box :
       {std::array{3.f, 2.f, 3.f, 4.f}, {4.f, 2.f, 3.f, 4.f}, {1.f, 4.f, 3.f, 2.f}})
    EXPECT_EQ(read(4, {box[0], box[1], box[2], box[3]})->left_out.without_area, 1u);
  const auto points = *read(8, {1, 2, 3, 4, 1, 0, kNan, 2});
  EXPECT_EQ(points.rows.size(), 1u);
  EXPECT_EQ(points.left_out.points_not_finite, 1u);
}

TEST(Detections, AreBounded) {
  std::vector<float> numbers;
  for (uint32_t i = 0; i < kRowLimit + 7; ++i)
    numbers.insert(numbers.end(), {static_cast<float>(i), 0, static_cast<float>(i + 1), 1});
  const auto many = *read(4, numbers);
  EXPECT_EQ(many.rows.size(), kRowLimit);
  EXPECT_EQ(many.left_out.beyond_limit, 7u);
}

TEST(Detections, HaveClassesWithinTheirRange) {
  EXPECT_EQ(read(6, {0, 0, 1, 1, 1, -3})->rows[0].class_index, 0u);
  EXPECT_EQ(read(6, {0, 0, 1, 1, 1, 2.6f})->rows[0].class_index, 3u);
  EXPECT_EQ(read(6, {0, 0, 1, 1, 1, 1e30f})->rows[0].class_index, UINT32_MAX);
}

TEST(Detections, GoBackToThePictureByItsMap) {
  SourceMap map;
  map.xx = 4, map.x0 = 100, map.yy = 2, map.y0 = -6;
  map.source_width = 640, map.source_height = 360;
  const auto moved = *read(8, {1, 2, 3, 4, 1, 0, 10, 20}, {map});
  EXPECT_EQ(moved.rows[0].x1, 104);
  EXPECT_EQ(moved.rows[0].y1, -2);
  EXPECT_EQ(moved.rows[0].x2, 112);
  EXPECT_EQ(moved.rows[0].y2, 2);
  EXPECT_EQ(moved.points[0].x, 140);
  EXPECT_EQ(moved.points[0].y, 34);
  EXPECT_EQ(moved.picture_width, 640u);
  EXPECT_EQ(moved.picture_height, 360u);
  SourceMap turned;  // swaps x and y and mirrors x
  turned.xx = 0, turned.xy = -1, turned.x0 = 50, turned.yx = 1, turned.yy = 0;
  const auto upright = *read(4, {1, 2, 3, 7}, {turned});
  EXPECT_EQ(upright.rows[0].x1, 43);
  EXPECT_EQ(upright.rows[0].x2, 48);
  EXPECT_EQ(upright.rows[0].y1, 1);
  EXPECT_EQ(upright.rows[0].y2, 3);
}

TEST(Detections, HaveOneSourceMapEachOrOneForAll) {
  SourceMap first, second;
  second.x0 = 10;
  const auto both = *read(4, {0, 0, 1, 1, 0, 0, 1, 1}, {first, second});
  EXPECT_EQ(both.rows[0].x1, 0);
  EXPECT_EQ(both.rows[1].x1, 10);
  const auto wrong = read(4, {0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1}, {first, second});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(wrong.error().message(), "2 source maps");
  EXPECT_SAYS(wrong.error().message(), "one for each of 3 rows");
}

TEST(Detections, OfAMapThatIsNoneAreNotFinite) {
  SourceMap map;
  map.xx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(read(4, {0, 0, 1, 1}, {map})->left_out.not_finite, 1u);
  map.xx = 0;
  EXPECT_EQ(read(4, {0, 0, 1, 1}, {map})->left_out.without_area, 1u);
}

TEST(Detections, AreOneTensorOfFloats) {
  for (const TensorSpec& spec :
       {TensorSpec{ElementType::Float64, {6, 2}, ""}, TensorSpec{ElementType::UInt8, {4}, ""},
        TensorSpec{ElementType::Float32, {3, 2}, ""}, TensorSpec{ElementType::Float32, {7, 2}, ""},
        TensorSpec{ElementType::Float32, {6, 2, 2}, ""},
        TensorSpec{ElementType::Float32, {kNumberLimit + 2, 1}, ""}, TensorSpec{}}) {
    const auto status = check_detections(spec);
    ASSERT_FALSE(status) << spec.to_string();
    EXPECT_EQ(status.error().code, Code::SPEC_MISMATCH);
    EXPECT_SAYS(status.error().message(), "one tensor float32 K:N");
  }
  for (const uint32_t k : {4u, 5u, 6u, 8u, 16u, kNumberLimit})
    EXPECT_TRUE(check_detections({ElementType::Float32, {k, 3, 1, 1}, ""})) << k;
}

}  // namespace detections_test
}  // namespace weir::draw
