// Reads boxes from tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/boxes.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "says.hpp"

namespace weir::preprocess {
namespace boxes_test {

std::vector<Roi> regions_of(const std::vector<PictureBox>& boxes) {
  std::vector<Roi> out;
  for (const PictureBox& box : boxes) out.push_back(make_region(box, {}));
  return out;
}
template <class Number>
std::vector<Roi> read(ElementType type, const std::vector<Number>& numbers) {
  const TensorSpec spec{type, {4, static_cast<uint32_t>(numbers.size() / 4)}, ""};
  EXPECT_TRUE(check_boxes(spec));
  std::vector<PictureBox> out;
  read_boxes(spec, std::as_bytes(std::span(numbers)), &out);
  return regions_of(out);
}

TEST(Boxes, AreReadFromBothTypes) {
  EXPECT_EQ(read<uint32_t>(ElementType::UInt32, {1, 2, 3, 4, 4294967295u, 0, 4294967295u, 9}),
            (std::vector<Roi>{{1, 2, 3, 4}, {4294967295, 0, 4294967295, 9}}));
  EXPECT_EQ(read<float>(ElementType::Float32, {-1.4f, 2.6f, 3, 1.5f, 0.2f, 0, 0.2f, 5}),
            (std::vector<Roi>{{-1, 3, 3, 1}, {}}));
}

TEST(Boxes, NotANumberIsEmptyAndLargeBoxesAreClipped) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const auto boxes = read<float>(
      ElementType::Float32, {kNan, 0, 1, 1,  0,      kInf,   1,     1,     0,      0, -kInf,   1,
                             0,    0, 2, -3, -3e38f, -3e38f, 3e38f, 3e38f, -3e38f, 0, 3.2e38f, 1});
  ASSERT_EQ(boxes.size(), 6u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(boxes[i], Roi{}) << i;
  const Rect picture{2, 3, 10, 20};
  EXPECT_EQ(common_part(picture, boxes[4]).width, 0u);
  EXPECT_EQ(common_part(picture, boxes[5]), (Rect{2, 3, 10, 0}));
}

TEST(Boxes, AreClipped) {
  const Rect picture{2, 3, 10, 20};
  EXPECT_EQ(common_part(picture, {0, 0, 100, 100}), picture);
  EXPECT_EQ(common_part(picture, {-5, 20, 9, 9}), (Rect{2, 20, 2, 3}));
  EXPECT_EQ(common_part(picture, {12, 3, 1, 1}).width, 0u);
  EXPECT_EQ(common_part(picture, {4, 5, 0, 1}).width, 0u);
}

TEST(Boxes, OfOtherTypesOrShapesAreRejected) {
  for (const TensorSpec& spec :
       {TensorSpec{ElementType::Int32, {4, 2}, ""}, TensorSpec{ElementType::Float32, {5, 2}, ""},
        TensorSpec{ElementType::Float32, {4, 2, 2}, ""}, TensorSpec{ElementType::UInt32, {}, ""}}) {
    const auto status = check_boxes(spec);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::SPEC_MISMATCH);
    EXPECT_SAYS(status.error().message(), "uint32 4:N or float32 4:N");
  }
  EXPECT_TRUE(check_boxes({ElementType::UInt32, {4, 7, 1, 1}, ""}));
  EXPECT_TRUE(check_boxes({ElementType::UInt32, {4}, ""}));
}

weir_result_columns columns_of(const char* text) {
  weir_result_columns out;
  EXPECT_TRUE(weir_results_parse(text, 0, &out)) << text;
  return out;
}
std::vector<Roi> of_rows(const char* columns, const std::vector<float>& numbers,
                         uint64_t first_row = 0) {
  std::vector<PictureBox> out;
  read_result_boxes(columns_of(columns), std::as_bytes(std::span(numbers)), first_row, &out);
  return regions_of(out);
}

TEST(ResultBoxes, HaveTheNumbersOfTheirRows) {
  EXPECT_EQ(of_rows("score,x1,y1,x2,y2", {0.5f, 1, 2, 4, 8, 0, 1, 1, 9, 9, 0.1f, -3, 0, 3, 1}),
            (std::vector<Roi>{{1, 2, 3, 6, 1}, {-3, 0, 6, 1, 3}}))
      << "the second row is background";
  EXPECT_EQ(of_rows("x1,y1,x2,y2", {1, 2, 4, 8}, 7), (std::vector<Roi>{{1, 2, 3, 6, 8}}));
}

TEST(ResultBoxes, OfRotatedObjectsAreUpright) {
  const float quarter = 1.57079633f;
  EXPECT_EQ(of_rows("x1,y1,x2,y2,rotation", {10, 10, 30, 14, quarter}),
            (std::vector<Roi>{{18, 2, 4, 20, 1}}));
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(of_rows("x1,y1,x2,y2,rotation", {10, 10, 30, 14, kNan}),
            (std::vector<Roi>{{10, 10, 20, 4, 1}}));
}

TEST(ResultBoxes, ThatAreNoneAreEmptyOrLeftOut) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(of_rows("score,class", {0.5f, 3}).empty()) << "rows of the whole picture";
  EXPECT_TRUE(of_rows("x1,y1,x2,y2,score", {0, 0, 1, 1, kNan}).empty());
  const auto boxes = of_rows("x1,y1,x2,y2", {kNan, 0, 1, 1, 5, 5, 5, 9, 5, 5, 4, 9});
  ASSERT_EQ(boxes.size(), 3u) << "regions that show nothing are counted later";
  for (const Roi& box : boxes) EXPECT_EQ(box.width, 0);
  EXPECT_TRUE(of_rows("x1,y1,x2,y2", {1, 2, 3}).empty()) << "less than a row";
}

TEST(ResultBoxes, NeedTensorsOfTheirColumns) {
  const auto columns = columns_of("x1,y1,x2,y2,score");
  EXPECT_TRUE(check_result_rows({ElementType::Float32, {5, 9}, ""}, columns));
  EXPECT_TRUE(check_result_rows({ElementType::Float32, {5, 9, 1, 1}, ""}, columns));
  for (const TensorSpec& other :
       {TensorSpec{ElementType::Float32, {4, 9}, ""}, TensorSpec{ElementType::Float64, {5, 9}, ""},
        TensorSpec{ElementType::Float32, {5, 9, 2}, ""}, TensorSpec{}}) {
    const auto status = check_result_rows(other, columns);
    ASSERT_FALSE(status);
    EXPECT_SAYS(status.error().message(), "does not have the columns that its caps define");
    EXPECT_SAYS(status.error().message(), "needed: float32 5:N");
  }
}

TEST(PictureBoxes, AreScaledBeforeTheyAreShapedAndRounded) {
  const PictureBox box{.left = 0.4, .top = 1, .right = 2.4, .bottom = 2.4, .row = 3};
  EXPECT_EQ(make_region(box, {}, {10, 10}), (Roi{4, 10, 20, 14, 3}));
  // The longer side is that in the picture of the region: 28 of 20 x 28.
  EXPECT_EQ(make_region(box, {.is_square = true}, {10, 20}), (Roi{0, 20, 28, 28, 3}));
  EXPECT_EQ(make_region({.left = 0, .top = 0, .right = NAN, .bottom = 1}, {}, {2, 2}), Roi{});
}

TEST(PictureBoxes, OfWholePicturesAreScaled) {
  const Size hd{1920, 1080}, square{300, 300};
  const auto scales = [](Size from, Size to, double pixel_aspect = 1) {
    const auto scale = find_scale(from, to, pixel_aspect);
    return scale && scale->x == double{1} * to.width / from.width &&
           scale->y == double{1} * to.height / from.height;
  };
  EXPECT_TRUE(scales(hd, {640, 360}));
  EXPECT_TRUE(scales(hd, {300, 169})) << "rounded";
  EXPECT_TRUE(scales({640, 368}, {320, 176})) << "rounded to 16";
  EXPECT_TRUE(scales(hd, {960, 1080}, 2)) << "wide pixels";
  EXPECT_TRUE(scales({960, 1080}, {480, 540}, 2));
  // A part is not larger than the whole.
  EXPECT_TRUE(scales(square, hd));
  EXPECT_TRUE(scales(square, {640, 240}));
  EXPECT_TRUE(scales({640, 480}, hd));
}

TEST(PictureBoxes, OfOtherPartsOfAPictureAreNotScaled) {
  const Size hd{1920, 1080};
  for (const Size part : {Size{960, 1080}, Size{1920, 540}, Size{1910, 1080}, Size{800, 800}})
    EXPECT_FALSE(find_scale(hd, part, 1)) << part.width;
  EXPECT_FALSE(find_scale({640, 368}, {640, 360}, 1)) << "rows that a codec adds";
  for (const auto& [from, to] : {std::pair{Size{}, hd}, {hd, Size{}}}) {
    const auto scale = find_scale(from, to, 1);
    ASSERT_TRUE(scale) << "not known";
    EXPECT_EQ(scale->x, 1);
    EXPECT_EQ(scale->y, 1);
  }
}

TEST(PictureBoxes, WithoutAreaHaveNoShape) {
  const RegionShape shapes[] = {{}, {.is_square = true}, {.scale = 3, .follows_rotation = true}};
  for (const RegionShape& shape : shapes) {
    EXPECT_EQ(make_region({.left = 20, .top = 20, .right = 20, .bottom = 50, .row = 2}, shape),
              (Roi{0, 0, 0, 0, 2}));
    EXPECT_EQ(make_region({.left = 20, .top = 20, .right = 15, .bottom = 50, .rotation = 1}, shape),
              Roi{});
  }
}

}  // namespace boxes_test
}  // namespace weir::preprocess
