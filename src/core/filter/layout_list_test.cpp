// inputlayout and outputlayout.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/layout_list.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace layout_list_test {

using Numbers = std::vector<uint32_t>;

TEST(Layout, ParsesNamesSeparatedByCommasAndDotsInAnyCase) {
  EXPECT_EQ(parse_layout_list("", "inputlayout"), Numbers{});
  EXPECT_EQ(parse_layout_list("NHWC,nchw.Any , none", "inputlayout"), (Numbers{1, 2, 0, 3}));
}

TEST(Layout, UnknownNamesBecomeNoneWithAWarning) {
  std::optional<Error> warning;
  EXPECT_EQ(parse_layout_list("NHWC,NHCW,x", "outputlayout", &warning), (Numbers{1, 3, 3}));
  ASSERT_TRUE(warning);
  const auto text = warning->message();
  EXPECT_SAYS(text, "offered: outputlayout=NHWC,NHCW,x");
  EXPECT_SAYS(text, "at \"NHCW\"");
  warning.reset();
  parse_layout_list("NHWC", "inputlayout", &warning);
  EXPECT_FALSE(warning);
}

TEST(Layout, AnyKeepsTheModelsLayout) {
  std::vector<ModelTensor> shapes(3);
  shapes[0].layout = shapes[1].layout = 1;
  set_layouts({0, 2}, &shapes);
  EXPECT_EQ(shapes[0].layout, 1u);
  EXPECT_EQ(shapes[1].layout, 2u);
  EXPECT_EQ(shapes[2].layout, 0u);
  set_layouts({1, 1, 1, 1, 1}, &shapes);
  EXPECT_EQ(shapes[2].layout, 1u);
}

}  // namespace layout_list_test
}  // namespace weir
