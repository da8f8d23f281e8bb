// Tests the parsing of custom=.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/custom_options.hpp"

#include <gtest/gtest.h>

namespace weir::infer {
namespace custom_options_test {

using Pairs = std::vector<std::pair<std::string, std::string>>;

TEST(CustomOptions, AreKeysAndValuesWithoutTheBlanksAroundThem) {
  EXPECT_EQ(custom_options(" NumThreads : 2 ,Delegate:XNNPACK"),
            (Pairs{{"NumThreads", "2"}, {"Delegate", "XNNPACK"}}));
  EXPECT_EQ(custom_options("path:/a:b"), (Pairs{{"path", "/a:b"}})) << "the first colon divides";
}

TEST(CustomOptions, WithoutAColonHaveNoValue) {
  EXPECT_EQ(custom_options("fast,,slow:"), (Pairs{{"fast", ""}, {"slow", ""}}));
  EXPECT_EQ(custom_options(" , "), Pairs{});
  EXPECT_EQ(custom_options(""), Pairs{});
}

}  // namespace custom_options_test
}  // namespace weir::infer
