// Merges the user's properties with a model's declaration.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/model_description.hpp"

#include <gtest/gtest.h>

#include "weir/abi.h"

namespace weir {
namespace model_description_test {

ModelTensor shape(std::vector<int64_t> dimensions, const std::string& name = "") {
  return {ElementType::Float32, true, std::move(dimensions), name, WEIR_LAYOUT_ANY};
}
TensorSpec floats(uint32_t count) {
  return {ElementType::Float32, {count}, ""};
}
const std::vector<ModelTensor> kIn{shape({-1, 4}, "x")}, kOut{shape({3}, "y"), shape({-1}, "z")};

ModelDescription described(const DeclaredTensors& declared) {
  std::vector<Error> warnings;
  auto made = describe_model({kIn, kOut}, declared, &warnings);
  EXPECT_TRUE(made) << made.error().what;
  EXPECT_TRUE(warnings.empty());
  return made ? *std::move(made) : ModelDescription{};
}
std::string refusal(const DeclaredTensors& declared) {
  std::vector<Error> warnings;
  const auto made = describe_model({kIn, kOut}, declared, &warnings);
  return made ? "none" : made.error().what;
}

TEST(ModelDescription, IsTheModelsWithoutProperties) {
  const auto model = described({});
  EXPECT_EQ(dimensions_text(model.inputs), "4:1") << "1 for what is open";
  EXPECT_EQ(types_text(model.outputs), "float32,float32");
  EXPECT_EQ(names_text(model.outputs), "y,z");
  EXPECT_EQ(layouts_text(model.outputs), "ANY,ANY");
  EXPECT_EQ(ranks_text(model.inputs), "2");
  EXPECT_EQ(dimensions_text({}) + ranks_text({}), "");
}

TEST(ModelDescription, UsersPropertiesOverrideTheModel) {
  const auto model =
      described({.input = "4:2", .inputname = "a", .outputname = ",b", .outputlayout = "NHWC"});
  EXPECT_EQ(dimensions_text(model.inputs), "4:2");
  EXPECT_EQ(names_text(model.inputs), "a");
  EXPECT_EQ(names_text(model.outputs), "y,b");
  EXPECT_EQ(layouts_text(model.outputs), "NHWC,ANY");
}

TEST(ModelDescription, WarnsAboutUnknownLayouts) {
  std::vector<Error> warnings;
  const DeclaredTensors declared{.inputlayout = "up", .outputlayout = "down"};
  ASSERT_TRUE(describe_model({kIn, kOut}, declared, &warnings));
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(warnings[0].offered, "inputlayout=up");
  EXPECT_EQ(warnings[1].offered, "outputlayout=down");
}

TEST(ModelDescription, RejectsPropertiesThatContradictTheModel) {
  EXPECT_EQ(refusal({.input = "5"}), "input contradicts the model");
  EXPECT_EQ(refusal({.outputtype = "uint8,uint8"}), "output contradicts the model");
  EXPECT_EQ(refusal({.input_combination = "x"}), "input-combination cannot be read");
  EXPECT_EQ(refusal({.output_combination = "o2"}),
            "output-combination names an output that the model lacks");
}

TEST(ModelDescription, KnowsTheStreamAsFarAsTheModelDefinesIt) {
  const auto whole = described({});
  ASSERT_EQ(whole.sink_spec().tensors.size(), 1u);
  ASSERT_EQ(whole.source_spec().tensors.size(), 2u);
  EXPECT_EQ(whole.source_spec().tensors[0].to_string(), "float32 3");
  const auto chosen = described({.input_combination = "1", .output_combination = "o1"});
  EXPECT_TRUE(chosen.sink_spec().tensors.empty()) << "the stream has other tensors too";
  EXPECT_EQ(chosen.source_spec().tensors.size(), 1u);
  EXPECT_TRUE(described({.output_combination = "i0,o0"}).source_spec().tensors.empty());
  EXPECT_EQ(described({.invoke_dynamic = true}).source_spec().format, Format::Flexible);
}

TEST(ModelDescription, HasNoOutputsIfTheModelLeavesTheirNumberOpen) {
  std::vector<Error> warnings;
  const auto model = describe_model({kIn, {}}, {.output_combination = "o0"}, &warnings);
  ASSERT_TRUE(model);
  EXPECT_TRUE(model->source_spec().tensors.empty());
}

TEST(ModelDescription, PutsPassedInputsBeforeTheOutputsOfAStream) {
  const auto model = described({.output_combination = "i1,o0"});
  const FrameSpec sink{Format::Static, {floats(4), floats(7)}, {30, 1}};
  const auto made = model.source_spec(sink, {shape({3}), shape({2})}, true);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->format, Format::Static);
  EXPECT_EQ(made->rate.numerator, 30);
  ASSERT_EQ(made->tensors.size(), 2u);
  EXPECT_EQ(made->tensors[0].to_string() + ", " + made->tensors[1].to_string(),
            "float32 7, float32 3");
  const auto open = model.source_spec(sink, kOut, false);
  ASSERT_TRUE(open);
  EXPECT_EQ(open->format, Format::Flexible);
  EXPECT_TRUE(open->tensors.empty());
  EXPECT_FALSE(model.source_spec({Format::Static, {floats(4)}, {}}, {shape({3}), shape({2})}, true))
      << "there is no second input";
}

TEST(ModelDescription, CompletesOutputsThatTheEngineLeavesOpen) {
  const auto model = described({.output = "3,5", .outputname = ",b"});
  const auto same = model.complete_outputs({shape({3}), shape({-1})});
  ASSERT_TRUE(same);
  EXPECT_EQ(dimensions_text(*same), "3,5");
  EXPECT_EQ(names_text(*same), "y,b");
  const auto none = model.complete_outputs({});
  ASSERT_TRUE(none);
  EXPECT_EQ(dimensions_text(*none), "3,5");
  const auto fewer = model.complete_outputs({shape({3})});
  ASSERT_FALSE(fewer);
  EXPECT_EQ(fewer.error().difference, "number of tensors");
  const auto contradicted = model.complete_outputs({shape({3}), shape({6})});
  ASSERT_FALSE(contradicted);
  EXPECT_EQ(contradicted.error().what, "output contradicts the model");
}

TEST(ModelDescription, RejectsAModelWithoutOutputs) {
  const auto made = ModelDescription{}.complete_outputs({});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().what, "the model declares no outputs for this stream");
}

}  // namespace model_description_test
}  // namespace weir
