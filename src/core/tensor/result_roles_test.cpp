// Tests the roles of tensors: the caps fields weir-columns and weir-source.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/result_roles.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace result_roles_test {

const ResultRole kRows{"x1,y1,x2,y2,score", "yolo"}, kMasks{"masks", "yolo"}, kNone{};

TEST(ResultRoles, AreReadAndWrittenForEachTensor) {
  const auto roles = parse_roles("x1,y1,x2,y2,score;;masks", "yolo;;yolo");
  EXPECT_EQ(roles, (ResultRoles{kRows, kNone, kMasks}));
  EXPECT_EQ(columns_text(roles), "x1,y1,x2,y2,score;;masks");
  EXPECT_EQ(sources_text(roles), "yolo;;yolo");
  EXPECT_EQ(columns_text({}), "");
}

TEST(ResultRoles, NeedNoSourcesAndIgnoreThoseTooMany) {
  EXPECT_EQ(parse_roles("masks;score", ""), (ResultRoles{{"masks", ""}, {"score", ""}}));
  EXPECT_EQ(parse_roles("masks", "a;b;c"), (ResultRoles{{"masks", "a"}}));
}

TEST(ResultRoles, OfStreamsWithoutResultsAreEmpty) {
  EXPECT_TRUE(parse_roles("", "yolo").empty());
  EXPECT_TRUE(parse_roles(";;", "a;b;c").empty()) << "no tensor is a result";
}

TEST(ResultRoles, AreBounded) {
  EXPECT_TRUE(parse_roles(std::string(65537, 'a'), "").empty());
  EXPECT_EQ(parse_roles(std::string(65536, 'a'), "").size(), 1u);
  std::string many = "score";
  for (size_t i = 0; i < 300; ++i) many += ";score";
  EXPECT_EQ(parse_roles(many, "").size(), 256u);
  EXPECT_EQ(parse_roles("score", std::string(70000, 'a'))[0].source, "");
}

TEST(ResultRoles, OfFramesSideBySideKeepTheirPlaces) {
  ResultRoles roles;
  append_roles({}, 2, 0, &roles);
  EXPECT_TRUE(roles.empty()) << "nothing to say yet";
  append_roles({kRows}, 2, 2, &roles);
  EXPECT_EQ(roles, (ResultRoles{kNone, kNone, kRows, kNone}));
  append_roles({}, 1, 4, &roles);
  append_roles({kMasks, kRows}, 1, 5, &roles);
  EXPECT_EQ(roles, (ResultRoles{kNone, kNone, kRows, kNone, kNone, kMasks}))
      << "a role without a tensor is left out";
}

TEST(ResultRoles, ArePickedWithTheTensors) {
  const ResultRoles roles{kRows, kNone, kMasks};
  const auto pick = [&](std::vector<size_t> tensors) { return pick_roles(roles, tensors); };
  EXPECT_EQ(pick({2, 0}), (ResultRoles{kMasks, kRows}));
  EXPECT_EQ(pick({1, 2, 9}), (ResultRoles{kNone, kMasks, kNone}));
  EXPECT_TRUE(pick({1}).empty());
  EXPECT_TRUE(pick({}).empty());
  EXPECT_TRUE(pick_roles({}, std::vector<size_t>{0, 1}).empty());
}

}  // namespace result_roles_test
}  // namespace weir
