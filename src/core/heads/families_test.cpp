// Tests of the choice of a family.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <gtest/gtest.h>

#include <set>

#include "core/text/text.hpp"
#include "says.hpp"

namespace weir::heads {
namespace {

TEST(Families, HaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const Family* family : all_families()) {
    EXPECT_TRUE(names.insert(std::string(family->name)).second) << family->name;
    for (const auto& alias : parse_name_list(family->aliases))
      EXPECT_TRUE(names.insert(alias).second) << alias;
    EXPECT_NE(family->tasks, 0u);
    EXPECT_FALSE(family->outputs.empty());
    EXPECT_GE(family->threshold, 0);
  }
}

TEST(Families, AreFoundByNameAndAliasInAnyCase) {
  EXPECT_EQ(family_named("yolov8", kDetection).name, "yolov8");
  EXPECT_EQ(family_named("YOLOv11", kDetection).name, "yolov8");
}

TEST(Families, NoModelOfAnyFamilyHasNoOutputs) {
  for (const Family* family : all_families()) {
    EXPECT_EQ(family->fit({}), Fit::No) << family->name;
    EXPECT_THROW(family->open({}, {}), Failure) << family->name;
  }
}

}  // namespace
}  // namespace weir::heads
