// Lists of tensors: reading, comparing, describing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/frame_spec.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace frame_spec_test {

FrameSpec video() {
  FrameSpec spec;
  spec.format = Format::Static;
  spec.tensors = {{ElementType::UInt8, Shape{3, 640, 480, 1}, "image"}};
  spec.rate = {30, 1};
  return spec;
}

TEST(Lists, AreSplitAtCommasAndDots) {
  const auto shapes = parse_shape_list("3:224:224:1,10.5:5");
  ASSERT_TRUE(shapes);
  EXPECT_EQ(shapes->size(), 3u);
  const auto types = parse_type_list("uint8, float32.INT64");
  ASSERT_TRUE(types);
  EXPECT_EQ((*types)[2], ElementType::Int64);
  EXPECT_EQ(parse_name_list("a,, b"), (std::vector<std::string>{"a", "", "b"}));
}

TEST(Lists, ReportThePlaceOfAnError) {
  const auto shapes = parse_shape_list("3:224,x:4");
  ASSERT_FALSE(shapes);
  EXPECT_EQ(shapes.error().code, Code::DIMENSION_SYNTAX);
  EXPECT_EQ(shapes.error().difference, "at \"x\" of \"x:4\"");
  const auto types = parse_type_list("uint8,float23");
  ASSERT_FALSE(types);
  EXPECT_EQ(types.error().difference, "at \"float23\"");
}

TEST(Lists, RejectTextAfterTheDimensions) {
  std::string seventeen = "2";
  for (int i = 0; i < 15; ++i) seventeen += ":2";
  EXPECT_TRUE(parse_shape_list(seventeen));
  seventeen += ":3";
  for (const std::string& text :
       {std::string("3:64:48:y"), std::string("3:64:4x8"), std::string("4,3:64:-1"), seventeen}) {
    const auto shapes = parse_shape_list(text);
    ASSERT_FALSE(shapes) << text;
    EXPECT_EQ(shapes.error().code, Code::DIMENSION_SYNTAX);
    EXPECT_EQ(shapes.error().offered, text);
  }
  EXPECT_EQ(parse_shape_list("3:64:4x8").error().difference, "at \"4x8\" of \"3:64:4x8\"");
  for (const char* text : {"3:4:0:0", "3:4::", " 3 : 4 "})
    EXPECT_EQ(parse_shape_list(text)->at(0).to_string(), "3:4") << text;
}

TEST(Lists, HaveAtMost256Entries) {
  std::string text = "1";
  for (int i = 1; i < 256; ++i) text += ",1";
  EXPECT_EQ(parse_shape_list(text)->size(), 256u);
  EXPECT_EQ(parse_shape_list(text + ",1").error().code, Code::LIMIT_EXCEEDED);
}

TEST(FrameSpec, IsEqualByReducedRatesAndShapes) {
  FrameSpec other = video();
  other.rate = {60, 2};
  other.tensors[0].shape = Shape{3, 640, 480};
  other.tensors[0].name = "x";
  EXPECT_EQ(video(), other);
  other.tensors[0].type = ElementType::Int8;
  EXPECT_FALSE(video() == other);
  other = video();
  other.rate = {};
  EXPECT_FALSE(video() == other);
}

TEST(FrameSpec, IsValidOnlyWhenWhole) {
  EXPECT_TRUE(video().valid());
  FrameSpec spec = video();
  spec.tensors.clear();
  EXPECT_FALSE(spec.valid());
  spec.format = Format::Flexible;
  EXPECT_TRUE(spec.valid());
  spec.format = Format::End;
  EXPECT_FALSE(spec.valid());
}

TEST(FrameSpec, CountsBytesAndRejectsOverflow) {
  EXPECT_EQ(video().bytes(), 921600u);
  FrameSpec spec = video();
  spec.tensors[0] = {ElementType::Float64, Shape{1u << 31, 1u << 31}, ""};
  EXPECT_FALSE(spec.bytes());
}

TEST(FrameSpec, IsDescribedAsText) {
  EXPECT_EQ(video().to_string(), "1 tensor: uint8 3:640:480:1");
  EXPECT_EQ(first_difference(video().tensors, video().tensors), "");
  auto other = video().tensors;
  other[0].shape = Shape{3, 320, 480};
  EXPECT_EQ(first_difference(other, video().tensors),
            "tensor 0: dimension is 3:320:480, needed is 3:640:480:1");
}

TEST(Names, OfFormatsAndMediaAreReadBack) {
  EXPECT_EQ(parse_format("FLEXIBLE"), Format::Flexible);
  EXPECT_EQ(parse_format("flex"), Format::End);
  EXPECT_EQ(media_type_of_caps_name("video/x-raw"), MediaType::Video);
  EXPECT_EQ(media_type_of_caps_name("application/json"), MediaType::Invalid);
}

}  // namespace frame_spec_test
}  // namespace weir
