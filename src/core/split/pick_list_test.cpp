// Parses tensorpick and similar lists.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/split/pick_list.hpp"

#include <gtest/gtest.h>

#include "says.hpp"

namespace weir {
namespace pick_list_test {

TEST(TensorGroups, AcceptAllSeparators) {
  const TensorGroups expected{{0}, {1, 2}, {3}, {4, 5, 6}, {7}};
  EXPECT_EQ(*parse_tensor_groups("tensorpick", "0,1:2.3;4+5:6/7"), expected);
  EXPECT_EQ(*parse_tensor_groups("tensorpick", " 0 , 1 : 2 . 3 ; 4 + 5:6 / 7 "), expected);
  EXPECT_EQ(*parse_tensor_groups("tensorpick", "2:0"), (TensorGroups{{2, 0}}));
  EXPECT_EQ(*parse_tensor_groups("tensorpick", "1,1"), (TensorGroups{{1}, {1}}));
  EXPECT_TRUE(parse_tensor_groups("tensorpick", "")->empty());
  EXPECT_TRUE(parse_tensor_groups("tensorpick", "  ")->empty());
}

TEST(TensorGroups, ShowThePlaceOfATypo) {
  const auto at = [](const char* text) {
    const auto groups = parse_tensor_groups("tensorpick", text);
    EXPECT_FALSE(groups) << text;
    return groups ? std::string() : groups.error().message();
  };
  EXPECT_SAYS(at("0,x:2"), "WEIR-1001: tensorpick cannot be read");
  EXPECT_SAYS(at("0,x:2"), "offered: tensorpick=0,x:2");
  EXPECT_SAYS(at("0,x:2"), "at character 3:\n    0,x:2\n      ^");
  EXPECT_SAYS(at("0, 1 2"), "at character 4:\n    0, 1 2\n       ^");
  EXPECT_SAYS(at("0,,1"), "at character 3:");
  EXPECT_SAYS(at("0,1,"), "at the end:");
  EXPECT_SAYS(at("-1"), "at character 1:");
  EXPECT_SAYS(at("1:"), "at the end:");
  EXPECT_SAYS(at("0-2"), "at character 1:");
  EXPECT_SAYS(at("99999999999999999999"), "at character 1:");
}

TEST(TensorGroups, HoldAtMost256Tensors) {
  std::string text = "0";
  for (int i = 1; i < 256; ++i) text += ":" + std::to_string(i);
  EXPECT_TRUE(parse_tensor_groups("tensorpick", text));
  EXPECT_SAYS(parse_tensor_groups("tensorpick", "9," + text + ":0").error().message(),
              "257 in group 1");
}

TEST(IndexList, AcceptsItsOwnSeparatorsOnly) {
  EXPECT_EQ(*parse_index_list("then-option", "2, 0", ","), (std::vector<size_t>{2, 0}));
  EXPECT_TRUE(parse_index_list("then-option", " ", ",")->empty());
  EXPECT_SAYS(parse_index_list("then-option", "1;2", ",").error().message(), "then-option=1;2");
  EXPECT_EQ(*parse_index_list("tensorpick", "1;2", kPickSeparators), (std::vector<size_t>{1, 2}));
}

TEST(IndexBeyond, NamesIndexAndCount) {
  const auto text = index_beyond("tensorpick", "tensor", 7, 3).message();
  EXPECT_SAYS(text, "WEIR-1004: tensorpick names a tensor that does not exist");
  EXPECT_SAYS(text, "offered: index 7");
  EXPECT_SAYS(text, "there are 3 tensors");
}

}  // namespace pick_list_test
}  // namespace weir
