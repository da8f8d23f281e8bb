// Tests of the choice of a family.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <gtest/gtest.h>

#include <set>

#include "core/heads/head_test_support.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/text.hpp"

namespace weir::heads {
namespace families_test {

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
    EXPECT_EQ(family->fit({}), Match::No) << family->name;
    EXPECT_THROW(family->open({}, {}), Failure) << family->name;
  }
}

TEST(Families, NoneOpensExtentsOfZeroOrBeyondMemory) {
  constexpr uint32_t kMax = 4294967295;
  for (const Shape& shape :
       {Shape{}, Shape{0}, Shape{0, 17}, Shape{17, 0, 9}, Shape{kMax, kMax, kMax}})
    for (const size_t count : {1u, 2u, 3u, 12u}) {
      const ModelSignature model{
          .outputs = {count,
                      OutputSignature{{.type = ElementType::Float32, .shape = shape, .name = {}}}},
          .input = {320, 240},
          .metadata = {},
          .labels = 2};
      EXPECT_THROW(recognise(model, ~0u), Failure) << shape.to_string();
      for (const Family* family : all_families())
        EXPECT_THROW(open_head(*family, model, {}), Failure)
            << family->name << " " << shape.to_string();
    }
}

// Outputs of random shapes, types and numbers: a head is refused, or gives finite results that fit
// together.
TEST(Families, ReadAnyOutputsOrRefuseThem) {
  std::mt19937 random(11);
  const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
  const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 0, 1, 0.5f};
  const uint32_t extents[] = {1, 1, 2, 3, 4, 5, 6, 7, 8, 16, 18, 21, 27, 32, 56, 84, 85, 100};
  size_t opened = 0;
  for (int round = 0; round < 900; ++round) {
    std::vector<TestOutput> outputs;
    const uint32_t first = extents[below(std::size(extents))];  // extents that outputs share
    for (uint32_t i = 1 + below(4); i > 0; --i) {
      Shape shape;
      for (uint32_t d = 1 + below(4), k = 0; k < d; ++k)
        shape[k] = below(3) == 0 ? first : extents[below(std::size(extents))];
      for (size_t k = 0; *shape.count() > 3000; ++k) shape[k] = 1;
      Floats numbers(*shape.count());
      for (float& number : numbers)
        number =
            below(20) == 0 ? odd[below(std::size(odd))] : static_cast<float>(below(1000)) / 500;
      TestOutput output(shape.to_string().c_str(), numbers);
      outputs.push_back(below(4) == 0 ? output.halved() : output);
    }
    for (const Family* family : all_families()) {
      HeadSetup setup{.head = std::string(family->name),
                      .tasks = family->tasks,
                      .input = below(2) ? Size{64, 64} : Size{},
                      .labels = below(8),
                      .threshold = static_cast<float>(below(3)) / 4};
      const HeadResult result = run_head(outputs, setup);
      if (!result.error.empty()) continue;
      ++opened;
      const auto& details = result.details;
      for (const auto& candidate : result.found)
        EXPECT_TRUE(candidate.is_finite() && candidate.score > 0 && std::isfinite(candidate.score))
            << family->name << " " << candidate.score;
      const size_t objects = result.found.size();
      EXPECT_EQ(details.points.size(), objects * result.features.points_per_object) << family->name;
      EXPECT_EQ(details.masks.size(), objects * details.mask_width * details.mask_height);
      EXPECT_EQ(details.class_scores.size(), objects * details.n_classes) << family->name;
      const size_t pixels = size_t{details.map_width} * details.map_height;
      EXPECT_EQ(details.class_map.size(), result.features.has_class_map ? pixels : 0);
      EXPECT_EQ(details.depth.size(), result.features.has_depth ? pixels : 0);
    }
  }
  EXPECT_GT(opened, 300u);
}

}  // namespace families_test
}  // namespace weir::heads
