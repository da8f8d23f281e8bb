// Tests of classifiers, segmentation and depth networks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/head_test_support.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace map_heads_test {

HeadResult classify(const TestOutput& output, float threshold = 0.1f,
                    std::map<std::string, std::string> custom = {}) {
  return run_head({output},
                  {.tasks = kClassification, .custom = std::move(custom), .threshold = threshold});
}

TEST(Classifier, GivesOneRowForEachClassOfAProbability) {
  const auto result = classify({"4:1", {0.6f, 0.1f, 0.3f, 0}});
  EXPECT_EQ(result.family, "classifier") << result.error;
  EXPECT_FALSE(result.features.has_boxes);
  EXPECT_TRUE(result.features.has_class_scores);
  ASSERT_EQ(result.found.size(), 3u);
  EXPECT_EQ(result.found[0].score, 0.6f);
  EXPECT_EQ(result.found[2].class_index, 2);
  EXPECT_EQ(result.details.n_classes, 4u);
  ASSERT_EQ(result.details.class_scores.size(), 12u);
  EXPECT_EQ(result.details.class_scores[6], 0.3f);
}

// Of the logits log(p) + c, whose softmax is p.
TEST(Classifier, TurnsLogitsIntoProbabilities) {
  const Floats probabilities{0.5f, 0.3f, 0.15f, 0.05f};
  for (const float shift : {0.0f, 7.0f, -90.0f, 500.0f}) {
    Floats logits;
    for (const float p : probabilities) logits.push_back(std::log(p) + shift);
    const auto result = classify({"1:1:4:1", logits}, 0);
    ASSERT_EQ(result.found.size(), 4u) << result.error;
    for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(result.found[i].score, probabilities[i], 2e-5f);
  }
}

TEST(Classifier, ScoresOfSeveralLabelsStay) {
  const auto result = classify({"3:1", {0.9f, 0.8f, 0.05f}});
  ASSERT_EQ(result.found.size(), 2u);
  EXPECT_EQ(result.found[1].score, 0.8f);
}

TEST(Classifier, TheKindOfScoresCanBeNamed) {
  const TestOutput output("2:1", {0.5f, 0.5f});
  EXPECT_EQ(classify(output, 0.1f, {{"scores", "probabilities"}}).found[0].score, 0.5f);
  const TestOutput zeros("2:1", {0, 0});
  EXPECT_EQ(classify(zeros, 0.1f, {{"scores", "logits"}}).found[0].score, 0.5f);
  EXPECT_EQ(classify(zeros).found.size(), 0u);
  EXPECT_SAYS(classify(zeros, 0, {{"scores", "percent"}}).error, "custom=scores:percent");
}

TEST(Classifier, ReadsQuantisedScores) {
  const auto bytes = TestOutput::of(ElementType::UInt8, "3:1", std::vector<uint8_t>{0, 51, 204});
  const auto unknown = classify(bytes);  // without a scale, 255 is 1
  ASSERT_EQ(unknown.found.size(), 2u) << unknown.error;
  EXPECT_NEAR(unknown.found[1].score, 0.8f, 1e-6f);
  const auto chars = TestOutput::of(ElementType::Int8, "3:1", std::vector<int8_t>{-128, -77, 76});
  EXPECT_NEAR(classify(chars).found[1].score, 0.8f, 1e-6f);
  // real = 0.1 * (value - 50): logits 0, 5.1 - 5, 20.4 - 5.
  TestOutput logits = bytes;
  logits.mark_quantised(0.1f, 50);
  ASSERT_EQ(classify(logits).found.size(), 1u);
  EXPECT_NEAR(classify(logits).found[0].score, 1, 1e-5f);
}

TEST(Classifier, NumbersThatAreNotFiniteHaveNoProbability) {
  EXPECT_EQ(classify({"3:1", {NAN, NAN, NAN}}).found.size(), 0u);
  EXPECT_EQ(classify({"3:1", {INFINITY, INFINITY, NAN}}).found.size(), 0u);
  const auto result = classify({"3:1", {3, NAN, -INFINITY}});
  ASSERT_EQ(result.found.size(), 1u);
  EXPECT_EQ(result.found[0].score, 1);
}

TEST(Classifier, RefusesOtherOutputs) {
  EXPECT_SAYS(
      run_head({TestOutput("3:3:1", Floats(9))}, {.head = "classifier", .tasks = kClassification})
          .error,
      "the outputs are not those of the head classifier");
}

HeadResult segment(const TestOutput& output, Size input = {8, 4}, std::string head = "",
                   std::map<std::string, std::string> custom = {}) {
  return run_head({output}, {.head = std::move(head),
                             .tasks = kSegmentation,
                             .input = input,
                             .custom = std::move(custom),
                             .threshold = 0.5f});
}

// A map of 4 x 2 pixels whose class is (x + 2 * y) % 3, as scores of 3 classes.
TEST(Segmentation, TakesTheBestClassInBothOrders) {
  Floats packed;
  std::vector<uint16_t> expected;
  for (size_t y = 0; y < 2; ++y)
    for (size_t x = 0; x < 4; ++x) {
      expected.push_back(static_cast<uint16_t>((x + 2 * y) % 3));
      for (size_t c = 0; c < 3; ++c) packed.push_back(c == expected.back() ? 2.0f : -7.0f);
    }
  for (const auto& output :
       {TestOutput("3:4:2:1", packed), TestOutput("4:2:3:1", transposed(packed, 3)),
        TestOutput("3:4:2:1", packed).halved()}) {
    const auto result = segment(output);
    EXPECT_EQ(result.family, "deeplab") << result.error;
    EXPECT_TRUE(result.features.has_class_map);
    EXPECT_EQ(result.details.map_width, 4u);
    EXPECT_EQ(result.details.map_height, 2u);
    EXPECT_EQ(result.details.class_map, expected);
  }
}

TEST(Segmentation, ManyPixelsInPlanesAreThoseOfPackedOnes) {
  constexpr size_t kWidth = 61, kHeight = 53, kClasses = 7;
  std::mt19937 random(9);
  std::uniform_int_distribution<int> score(-3, 3);  // equal scores: the first class wins
  Floats packed(kWidth * kHeight * kClasses);
  for (float& number : packed) number = static_cast<float>(score(random));
  packed[5] = NAN;
  const auto a = segment({"7:61:53:1", packed}, {122, 106});
  const auto b = segment({"61:53:7:1", transposed(packed, kClasses)}, {122, 106});
  ASSERT_EQ(a.details.class_map.size(), kWidth * kHeight) << a.error;
  EXPECT_EQ(a.details.class_map, b.details.class_map);
  for (size_t i = 0; i < 20; ++i) {
    size_t best = 0;
    for (size_t c = 1; c < kClasses; ++c)
      if (packed[i * kClasses + c] > packed[i * kClasses + best]) best = c;
    EXPECT_EQ(a.details.class_map[i], best);
  }
}

TEST(Segmentation, OneScoreAPixelIsOfClass1) {
  EXPECT_EQ(segment({"2:2:1", {0.4f, 0.5f, 0.9f, 0}}, {4, 4}).details.class_map,
            (std::vector<uint16_t>{0, 1, 1, 0}));
  EXPECT_EQ(segment({"1:2:2:1", {-3, 0, 4, NAN}}, {4, 4}).details.class_map,
            (std::vector<uint16_t>{0, 1, 1, 0}));
}

TEST(Segmentation, ReadsNumbersOfClasses) {
  const auto numbers =
      TestOutput::of(ElementType::Int64, "2:2:1", std::vector<int64_t>{0, 3, 20, 1});
  const auto result = segment(numbers, {4, 4});
  EXPECT_EQ(result.family, "class-map") << result.error;
  EXPECT_EQ(result.details.class_map, (std::vector<uint16_t>{0, 3, 20, 1}));
  EXPECT_EQ(segment({"2:2:1", {0, 3, 20, 1}}, {4, 4}, "class-map").details.class_map,
            (std::vector<uint16_t>{0, 3, 20, 1}));
  EXPECT_SAYS(segment({"2:2:1", {0, 3, -2, 1}}, {4, 4}, "class-map").error, "at pixel 0, 1");
}

TEST(Segmentation, WholeNumbersThatAreNoScoresAreClasses) {
  const TestOutput classes("2:2:1", {0, 3, 20, 1});
  const auto result = segment(classes, {4, 4});
  EXPECT_EQ(result.details.class_map, (std::vector<uint16_t>{0, 3, 20, 1})) << result.error;
  EXPECT_EQ(result.warning, "");
  const auto forced = segment(classes, {4, 4}, "deeplab", {{"scores", "logits"}});
  EXPECT_EQ(forced.details.class_map, (std::vector<uint16_t>{1, 1, 1, 1}));
  EXPECT_SAYS(forced.warning, "whole numbers up to 20");
  EXPECT_SAYS(forced.warning, "custom=head:class-map");
  EXPECT_EQ(segment({"2:2:1", {0, 2.5f, 20, 1}}, {4, 4}).details.class_map,
            (std::vector<uint16_t>{1, 1, 1, 1}))
      << "logits";
  EXPECT_EQ(run_head({classes}, {.tasks = kSegmentation, .input = {4, 4}, .labels = 21}).family,
            "class-map");
}

TEST(Segmentation, RefusesPicturesOfAnotherAspect) {
  EXPECT_SAYS(segment({"3:40:20:1", Floats(2400)}, {20, 20}).error,
              "no head of this mode fits these outputs");
}

TEST(HeatMaps, WarnOfMapsThatAreScoresOfClasses) {
  const auto read = [](float rest) {
    Floats planes(4 * 16 * 16, rest);  // 0.9 for the class of each pixel
    for (size_t pixel = 0; pixel < 256; ++pixel) planes[pixel % 4 * 256 + pixel] = 0.9f;
    return run_head({TestOutput("16:16:4:1", planes)}, {.head = "heat-maps", .tasks = kPose});
  };
  EXPECT_SAYS(read(0.1f / 3).warning, "4 maps whose sum is 1 in each cell");
  EXPECT_SAYS(read(0.1f / 3).warning, "tensor_decoder mode=segmentation");
  EXPECT_EQ(read(0.0f).warning, "");
}

TEST(HeatMaps, MayHaveAMapOfTheBackground) {
  Floats planes(18 * 256, 0);
  for (size_t pixel = 0; pixel < 256; ++pixel) planes[17 * 256 + pixel] = 1;
  for (size_t point = 0; point < 17; ++point) {
    const size_t peak = 15 * point + 1;
    planes[point * 256 + peak] = 0.9f, planes[17 * 256 + peak] = 0.1f;
  }
  const auto result =
      run_head({TestOutput("16:16:18:1", planes)}, {.head = "heat-maps", .tasks = kPose});
  EXPECT_EQ(result.found.size(), 1u) << result.error;
  EXPECT_EQ(result.warning, "");
}

TEST(Depth, IsTheMapOfTheNetwork) {
  for (const char* shape : {"3:2:1", "1:3:2:1", "3:2:1:1"}) {
    const auto result = run_head({TestOutput(shape, {1, 2, 3, -4, NAN, INFINITY})},
                                 {.tasks = kDepth, .input = {3, 2}});
    EXPECT_TRUE(result.features.has_depth) << result.error;
    EXPECT_EQ(result.details.map_width, 3u);
    EXPECT_EQ(result.details.map_height, 2u);
    EXPECT_EQ(result.details.depth, (Floats{1, 2, 3, -4, 0, 0}));
  }
  EXPECT_SAYS(run_head({TestOutput("3:3:3:1", Floats(27))}, {.tasks = kDepth}).error,
              "no head of this mode fits these outputs");
}

}  // namespace map_heads_test
}  // namespace weir::heads
