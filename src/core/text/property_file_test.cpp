// Property files: what counts as a line.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/property_file.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace property_file_test {

using Pairs = std::vector<std::pair<std::string_view, std::string_view>>;

TEST(PropertyFile, ReturnsKeysAndValuesWithoutBlanks) {
  EXPECT_EQ(parse_property_file("mode=direct_video\n  option1 =\tRGB \r\n"),
            (Pairs{{"mode", "direct_video"}, {"option1", "RGB"}}));
}
TEST(PropertyFile, KeepsFurtherSignsInTheValue) {
  EXPECT_EQ(parse_property_file("custom=a=b"), (Pairs{{"custom", "a=b"}}));
}
TEST(PropertyFile, SkipsLinesWithoutAPair) {
  EXPECT_EQ(parse_property_file("# a remark\n\n=value\nmode"), Pairs{});
  EXPECT_EQ(parse_property_file(""), Pairs{});
}
TEST(PropertyFile, KeepsEmptyValuesAndTheOrder) {
  EXPECT_EQ(parse_property_file("b=\na=1\nb=2"), (Pairs{{"b", ""}, {"a", "1"}, {"b", "2"}}));
}

}  // namespace property_file_test
}  // namespace weir
