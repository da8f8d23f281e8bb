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

TEST(Families, NoneFitsExtentsOfZeroOrBeyondMemory) {
  constexpr uint32_t kMost = 4294967295;
  for (const Shape& shape :
       {Shape{}, Shape{0}, Shape{4, 0}, Shape{0, 17}, Shape{17, 0, 9}, Shape{kMost, kMost, kMost}})
    for (const size_t count : {1u, 2u, 3u, 12u})
      for (const Family* family : all_families()) {
        const ModelFacts model{
            .outputs = {count, OutputFacts{.type = ElementType::Float32, .shape = shape}},
            .input = {320, 240},
            .metadata = {},
            .labels = 2};
        EXPECT_EQ(family->fit(model), Fit::No) << family->name << " " << shape.to_string();
        EXPECT_THROW(family->open(model, {}), Failure) << family->name;
      }
}

}  // namespace
}  // namespace weir::heads
