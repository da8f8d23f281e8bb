// Reads boxes from tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/boxes.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "says.hpp"

namespace weir::preprocess {
namespace {

template <class Number>
std::vector<Box> read(ElementType type, const std::vector<Number>& numbers) {
  const TensorSpec spec{type, {4, static_cast<uint32_t>(numbers.size() / 4)}, ""};
  EXPECT_TRUE(check_boxes(spec));
  std::vector<Box> out;
  read_boxes(spec, std::as_bytes(std::span(numbers)), &out);
  return out;
}

TEST(Boxes, AreReadFromBothTypes) {
  EXPECT_EQ(read<uint32_t>(ElementType::UInt32, {1, 2, 3, 4, 4294967295u, 0, 4294967295u, 9}),
            (std::vector<Box>{{1, 2, 3, 4}, {4294967295, 0, 4294967295, 9}}));
  EXPECT_EQ(read<float>(ElementType::Float32, {-1.4f, 2.6f, 3, 1.5f, 0.2f, 0, 0.2f, 5}),
            (std::vector<Box>{{-1, 3, 3, 1}, {}}));
}

TEST(Boxes, NotANumberIsEmptyAndLargeBoxesAreClipped) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const auto boxes = read<float>(
      ElementType::Float32, {kNan, 0, 1, 1,  0,      kInf,   1,     1,     0,      0, -kInf,   1,
                             0,    0, 2, -3, -3e38f, -3e38f, 3e38f, 3e38f, -3e38f, 0, 3.2e38f, 1});
  ASSERT_EQ(boxes.size(), 6u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(boxes[i], Box{}) << i;
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

}  // namespace
}  // namespace weir::preprocess
