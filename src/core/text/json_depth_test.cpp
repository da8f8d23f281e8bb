// The depth of JSON texts, whole and damaged.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/json_depth.hpp"

#include <gtest/gtest.h>

#include <string>

namespace weir {
namespace json_depth_test {

TEST(JsonDepth, IsThatOfTheDeepestValue) {
  EXPECT_EQ(json_depth(""), 0);
  EXPECT_EQ(json_depth("1"), 0);
  EXPECT_EQ(json_depth("{}"), 1);
  EXPECT_EQ(json_depth(R"([[1], {"a": [2]}, [[3]], 4])"), 3);
  EXPECT_EQ(json_depth(std::string(300000, '[')), 300000);
}

TEST(JsonDepth, IgnoresBracketsInStrings) {
  EXPECT_EQ(json_depth(R"(["[[[", "\"[[[", "\\", [1]])"), 2);
}

TEST(JsonDepth, OfDamagedTextIsNotNegative) {
  EXPECT_EQ(json_depth("]]]]"), 0);
  EXPECT_EQ(json_depth(R"(["\)"), 1);
}

}  // namespace json_depth_test
}  // namespace weir
