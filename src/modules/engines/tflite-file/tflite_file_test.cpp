// Tests the TensorFlow Lite file checks, without TensorFlow Lite: which files it must never open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/tflite_file.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "says.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace weir::engine {
namespace tflite_file_test {

using namespace engine_test;  // NOLINT: the builder's words

TfliteBuilder small_model() {
  return TfliteBuilder()
      .input("x", kTfFloat, {-1, 3})
      .constant<float>("c", kTfFloat, {3}, {1, 2, 3})
      .tensor("sum", kTfFloat, {1, 3})
      .output("y", kTfFloat, {1, 3})
      .node(kOpAdd, {"x", "c"}, {"sum"})
      .node(kOpRelu, {"sum"}, {"y"});
}

int score(std::vector<unsigned char> head) {
  return tflite_score(head);
}

// The error text for a rejected model; "" for an accepted one.
std::string refusal(const TfliteBuilder& model) {
  const auto summary = read_tflite(model.bytes());
  if (summary) return "";
  EXPECT_EQ(summary.error().code, Code::MODEL_INVALID);
  EXPECT_FALSE(summary.error().fix.empty());
  return summary.error().offered;
}

TEST(TfliteFile, ReportsItsContents) {
  const auto summary = read_tflite(small_model().bytes());
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->description, "weir tests");
  EXPECT_EQ(summary->subgraphs, 1u);
  EXPECT_EQ(summary->operators, 2u);
  EXPECT_EQ(summary->tensors, 4u);
  EXPECT_FALSE(summary->has_state);
  EXPECT_FALSE(summary->shapes_depend_on_data);
}

TEST(TfliteFile, DetectsStateAndShapesThatDependOnData) {
  const auto found = read_tflite(TfliteBuilder()
                                     .input("x", kTfBool, {4})
                                     .variable("state", kTfFloat, {4})
                                     .output("y", kTfInt64, {1, 1})
                                     .node(kOpWhere, {"x"}, {"y"})
                                     .bytes());
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_TRUE(found->shapes_depend_on_data);
  EXPECT_TRUE(found->has_state);
}

TEST(TfliteFile, RecognisesATensorFlowLiteFileByItsFirstBytes) {
  EXPECT_EQ(score({0x1C, 0, 0, 0, 'T', 'F', 'L', '3'}), 100);
  EXPECT_EQ(score({0x1C, 0, 0, 0, 'O', 'R', 'T', 'M'}), 0);
  EXPECT_EQ(score({0x1C, 0, 0, 0, 'T', 'F', 'L'}), 0);
  EXPECT_EQ(score({0x08, 0x07, 0x12, 0x07, 'p', 'y', 't', 'o'}), 0);
  EXPECT_EQ(score({}), 0);
}

// Bytes at the end without references may be missing; a rejection always has a text.
TEST(TfliteFile, RejectsATruncatedFile) {
  const auto whole = small_model().bytes();
  for (size_t size = 0; size < whole.size(); ++size) {
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size));
    const auto summary = read_tflite(cut);
    ASSERT_FALSE(summary) << size;
    EXPECT_EQ(summary.error().code, Code::MODEL_INVALID);
    EXPECT_FALSE(summary.error().offered.empty());
  }
  EXPECT_TRUE(read_tflite(whole));
}

TEST(TfliteFile, ReportsATruncatedFile) {
  auto bytes = small_model().bytes();
  bytes.resize(bytes.size() / 2);
  const auto summary = read_tflite(bytes);
  ASSERT_FALSE(summary);
  EXPECT_SAYS(summary.error().offered, "it was truncated or changed") << summary.error().message();
}

TEST(TfliteFile, EveryChangedByteIsHandled) {
  const auto whole = small_model().bytes();
  size_t refused = 0;
  for (size_t at = 0; at < whole.size(); ++at)
    for (const int value : {0, 1, 0x7F, 0x80, 0xFF}) {
      auto bytes = whole;
      bytes[at] = std::byte(value);
      refused += !read_tflite(bytes);
    }
  EXPECT_GT(refused, whole.size() / 4);
}

TEST(TfliteFile, RejectsFilesThatAreNotAModel) {
  EXPECT_FALSE(read_tflite({}));
  const auto error = read_tflite(std::vector<std::byte>(64)).error();
  EXPECT_SAYS(error.offered, "no identifier TFL3") << error.message();
}

TEST(TfliteFile, RejectsAnUnknownVersionOfTheSchema) {
  EXPECT_SAYS(refusal(small_model().version(2)), "version is 2, not 3");
}

TEST(TfliteFile, RejectsAModelWithoutOperators) {
  EXPECT_SAYS(refusal(TfliteBuilder().input("x", kTfFloat, {1})), "no operators");
}

TEST(TfliteFile, RejectsAGraphWithoutAnOutput) {
  EXPECT_SAYS(refusal(TfliteBuilder()
                          .input("x", kTfFloat, {1})
                          .tensor("y", kTfFloat, {1})
                          .node(kOpNeg, {"x"}, {"y"})),
              "no output");
}

TEST(TfliteFile, RejectsATensorUsedBeforeItIsWritten) {
  EXPECT_SAYS(refusal(TfliteBuilder()
                          .input("x", kTfFloat, {1})
                          .tensor("never", kTfFloat, {1})
                          .output("y", kTfFloat, {1})
                          .node(kOpAdd, {"x", "never"}, {"y"})),
              "before it is made");
}

TEST(TfliteFile, AcceptsAnEmptyTensorThatNoOperatorWrites) {
  const auto summary = read_tflite(TfliteBuilder()
                                       .input("x", kTfFloat, {1})
                                       .tensor("nothing", kTfFloat, {0})
                                       .output("y", kTfFloat, {1})
                                       .output("none", kTfFloat, {0})
                                       .node(kOpConcatenation, {"x", "nothing"}, {"y"})
                                       .bytes());
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_TRUE(summary->passes_through) << "no operator computes it";
}

TEST(TfliteFile, RejectsAnOutputThatNoOperatorWrites) {
  EXPECT_SAYS(refusal(tflite_negation().output("z", kTfFloat, {1})),
              "no operator produces an output");
}

TEST(TfliteFile, RejectsATensorThatDoesNotExist) {
  EXPECT_SAYS(refusal(TfliteBuilder()
                          .input("x", kTfFloat, {1})
                          .output("y", kTfFloat, {1})
                          .node(kOpAdd, {"x", "absent"}, {"y"})),
              "a tensor that does not exist");
}

TEST(TfliteFile, RejectsImpossibleShapes) {
  EXPECT_SAYS(refusal(tflite_negation({-5})), "impossible shape");
  EXPECT_SAYS(refusal(tflite_negation({1 << 20, 1 << 20, 1 << 20})), "impossible shape");
  EXPECT_SAYS(refusal(tflite_negation(std::vector<int32_t>(17, 1))), "rank 17");
}

TEST(TfliteFile, RejectsAnInvalidElementType) {
  EXPECT_SAYS(refusal(TfliteBuilder()
                          .input("x", 99, {1})
                          .output("y", kTfFloat, {1})
                          .node(kOpNeg, {"x"}, {"y"})),
              "element type 99");
}

TEST(TfliteFile, RejectsAConstantThatIsShorterThanItsShape) {
  EXPECT_SAYS(refusal(TfliteBuilder()
                          .input("x", kTfFloat, {4})
                          .constant<float>("c", kTfFloat, {4}, {1, 2, 3})
                          .output("y", kTfFloat, {4})
                          .node(kOpAdd, {"x", "c"}, {"y"})),
              "12 bytes instead of 16");
}

TEST(TfliteFile, RejectsInvalidScales) {
  const auto scaled = [](const TfliteQuantization& quantization) {
    return refusal(TfliteBuilder()
                       .input("x", kTfInt8, {2, 3})
                       .quantized(quantization)
                       .output("y", kTfFloat, {2, 3})
                       .node(kOpDequantize, {"x"}, {"y"}));
  };
  EXPECT_EQ(scaled({{0.5f}, {3}}), "");
  EXPECT_EQ(scaled({{0.5f, 1}, {3, 3}, 0}), "");
  EXPECT_SAYS(scaled({{-1}, {3}}), "quantisation");
  EXPECT_SAYS(scaled({{std::numeric_limits<float>::infinity()}, {3}}), "quantisation");
  EXPECT_SAYS(scaled({{std::numeric_limits<float>::quiet_NaN()}, {3}}), "quantisation");
  EXPECT_SAYS(scaled({{1, 1}, {3, 3}, 2}), "quantisation");        // there is no axis 2
  EXPECT_SAYS(scaled({{1, 1, 1}, {3, 3, 3}, 0}), "quantisation");  // axis 0 has 2 rows
  EXPECT_SAYS(scaled({{1, 1}, {3}, 0}), "quantisation");
}

TEST(TfliteFile, RejectsASubgraphThatCallsItself) {
  const auto branches = [](int32_t first, int32_t second) {
    return FlatValue::table({{0, FlatValue::scalar(first)}, {1, FlatValue::scalar(second)}});
  };
  const auto model = [&](const FlatValue& options) {
    return TfliteBuilder()
        .input("if", kTfBool, {1})
        .input("x", kTfFloat, {1})
        .output("y", kTfFloat, {1})
        .node(kOpIf, {"if", "x"}, {"y"})
        .options(92, options);
  };
  EXPECT_SAYS(refusal(model(branches(0, 0))), "calls itself");
  EXPECT_SAYS(refusal(model(branches(1, 1))), "a subgraph that does not exist");
  EXPECT_SAYS(refusal(model(branches(-1, 0))), "a subgraph that does not exist");
}

TEST(TfliteFile, RejectsACustomOperatorWithoutAName) {
  EXPECT_SAYS(refusal(TfliteBuilder()
                          .input("x", kTfFloat, {1})
                          .output("y", kTfFloat, {1})
                          .node(kOpCustom, {"x"}, {"y"})),
              "without a name");
}

}  // namespace tflite_file_test
}  // namespace weir::engine
