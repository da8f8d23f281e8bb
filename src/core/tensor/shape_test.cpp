// The dimension grammar, its equality and its limits (docs/compatibility/types-and-caps.md 1.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/shape.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace shape_test {

TEST(Shape, ReadsInnermostFirst) {
  const Shape s = Shape::parse(" 3 :224: 224:1");
  EXPECT_EQ(s[0], 3u);
  EXPECT_EQ(s.rank(), 4u);
  EXPECT_EQ(s.min_rank(), 3u);
  EXPECT_EQ(s.to_string(), "3:224:224:1");
  EXPECT_EQ(s.count(), 3u * 224 * 224);
}

TEST(Shape, StopsAtTheFirstEmptyPart) {
  EXPECT_EQ(Shape::parse("3::5").to_string(), "3");
}

TEST(Shape, OnesAndMissingDimensionsAreEqual) {
  EXPECT_EQ(Shape::parse("3:224:224"), Shape::parse("3:224:224:1:1"));
  EXPECT_FALSE(Shape::parse("3:224:224") == Shape::parse("3:224:224:2"));
  EXPECT_FALSE(Shape() == Shape());
}

TEST(Shape, NonNumericTextIsInvalid) {
  for (const char* text : {"", "x", "0", "-3", "3:x:4", "3:0:4", "4294967296", "1.5"})
    EXPECT_FALSE(Shape::parse(text).valid()) << text;
}

TEST(Shape, HasDimensionsOfZeroWhereTheRankIsSet) {
  Shape s{5, 0, 3};
  EXPECT_FALSE(s.valid());
  s.set_rank(3);
  EXPECT_TRUE(s.valid());
  EXPECT_TRUE(s.is_empty());
  EXPECT_EQ(s.count(), 0u);
  EXPECT_EQ(s.rank(), 3u);
  EXPECT_EQ(s.to_string(), "5:0:3");
  Shape five{5};
  five.set_rank(1);
  EXPECT_FALSE(five.is_empty());
  EXPECT_EQ(five, (Shape{5, 1}));
  Shape none{5, 0};
  none.set_rank(2);
  EXPECT_FALSE(none == (Shape{5}));
  EXPECT_FALSE(none == (Shape{5, 1}));
  EXPECT_EQ(none.with_rank(3).to_string(), "5:0:1");
}

TEST(Shape, AcceptsUpToSixteenDimensions) {
  std::string text = "2";
  for (int i = 0; i < 15; ++i) text += ":1";
  EXPECT_EQ(Shape::parse(text).rank(), 16u);
  EXPECT_FALSE(Shape::parse(text + ":1").rank() == 16u);  // the 16th part "1:1" is not a number
}

TEST(Shape, AProductBeyond63BitsHasNoCount) {
  EXPECT_FALSE((Shape{4294967295u, 4294967295u}).count());
  EXPECT_EQ((Shape{1u << 31, 1u << 31}).count(), uint64_t{1} << 62);
}

TEST(Shape, PadsAndCutsForCapsSpellings) {
  EXPECT_EQ((Shape{3, 4}).to_string(4), "3:4:1:1");
  EXPECT_EQ((Shape{3, 4, 5, 1, 1}).with_rank(4).to_string(), "3:4:5:1");
}

}  // namespace shape_test
}  // namespace weir
