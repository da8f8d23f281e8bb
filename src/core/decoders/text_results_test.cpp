// Tests of text: detection from maps and recognition from characters' probabilities.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/decoders/results_test_support.hpp"

namespace weir::decoders {
namespace text_results_test {

std::vector<float> line_map(size_t width, size_t height) {
  std::vector<float> map(width * height);
  for (size_t y = 20; y < 36; ++y)
    for (size_t x = 30; x < 91; ++x) map[y * width + x] = 0.8f;
  return map;
}

TEST(TextResults, LinesOfTextAreRotatedBoxes) {
  const TestTensor tensor("128:64:1:1", line_map(128, 64));
  const TestModel model{.input = "128:64:3:1", .names = {"sigmoid_0.tmp_0"}};
  for (const char* mode : {"text", "detection"}) {
    ResultsRun run(mode, {});
    ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
    run.decode({tensor});
    ASSERT_EQ(run.n_rows(), 1u) << run.error;
    const float growth = 60 * 15 * 1.5f / (2 * 75);
    EXPECT_NEAR(run.row(0).box().x1, 30.5f - growth, 1e-3);
    EXPECT_NEAR(run.row(0).box().y2, 35.5f + growth, 1e-3);
    EXPECT_EQ(run.row(0).rotation(), 0);
    EXPECT_NEAR(run.row(0).score(), 0.8, 1e-5);
  }
}

TEST(TextResults, BoxesTurnWithThePicture) {
  const TestTensor tensor("128:64:1:1", line_map(128, 64));
  const TestModel model{.input = "128:64:3:1", .names = {"sigmoid_0.tmp_0"}};
  SourceMap map;  // the source picture is turned by 90 degrees
  map.xx = 0, map.xy = -1, map.x0 = 64, map.yx = 1, map.yy = 0;
  map.width = 128, map.height = 64;
  ResultsRun run("text", {{"unclip", "0"}});
  ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
  run.decode({tensor}, {map});
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  EXPECT_NEAR(run.row(0).rotation(), std::acos(-1) / 2, 1e-5);
  EXPECT_NEAR(run.row(0).box().width(), 60, 1e-3);
  EXPECT_NEAR((run.row(0).box().y1 + run.row(0).box().y2) / 2, 60.5, 1e-3);
}

TEST(TextResults, DetectionHasSettings) {
  const TestTensor tensor("128:64:1:1", line_map(128, 64));
  const TestModel model{.input = "128:64:3:1", .names = {"sigmoid_0.tmp_0"}};
  const auto rows = [&](const DecoderOptions& options) {
    ResultsRun run("text", options);
    EXPECT_TRUE(run.configure({tensor}, &model)) << run.error;
    run.decode({tensor});
    return run.row(0).is_background() ? 0 : run.n_rows();
  };
  EXPECT_EQ(rows({{"threshold", "0.79"}}), 1u);
  EXPECT_EQ(rows({{"threshold", "0.81"}}), 0u);
  EXPECT_EQ(rows({{"pixel-threshold", "0.85"}}), 0u);
  for (const char* value : {"11", "-1", "nan", "a"}) {
    ResultsRun run("text", {{"unclip", value}});
    EXPECT_FALSE(run.configure({tensor}, &model));
    EXPECT_SAYS(run.error, std::string("custom=unclip:") + value);
    EXPECT_SAYS(run.error, "custom=unclip:1.5");
  }
}

// Steps of the given classes; the class has `score`, the others share the rest.
std::vector<float> steps(const std::vector<size_t>& classes, size_t n, float score = 0.9f) {
  std::vector<float> out;
  for (const size_t step : classes)
    for (size_t i = 0; i < n; ++i)
      out.push_back(i == step ? score : (1 - score) / static_cast<float>(n - 1));
  return out;
}

// Classes: blank, a, é, 漢, z and, in a model of 6 classes, the space.
std::string dictionary() {
  static const std::string path =
      file_with("text-dictionary.txt", "a\n\xC3\xA9\n\xE6\xBC\xA2\nz\n");
  return path;
}

struct Read {
  std::string text, error;
  float score = 0;
};
Read read(const std::string& shape, const std::vector<float>& values,
          const DecoderOptions& options = {{"labels", dictionary()}}) {
  const TestTensor tensor(shape, values);
  ResultsRun run("text", options);
  if (!run.configure({tensor})) return {.text = {}, .error = run.error};
  run.decode({tensor});
  if (!run.error.empty()) return {.text = {}, .error = run.error};
  const auto& text = run.results.at(1);
  EXPECT_EQ(text.columns.kind, WEIR_RESULT_TEXT);
  EXPECT_FALSE(run.row(0).has_box());
  std::string bytes(text.payload.begin(), text.payload.end());
  return {.text = bytes.c_str(), .error = {}, .score = run.row(0).score()};
}

TEST(TextResults, RepetitionsAndBlanksAreRemoved) {
  const auto found = read("6:9:1", steps({0, 1, 1, 0, 1, 2, 3, 3, 0}, 6));
  EXPECT_EQ(found.text, "aa\xC3\xA9\xE6\xBC\xA2") << found.error;
  EXPECT_NEAR(found.score, 0.9, 1e-6);
}

TEST(TextResults, TheClassAfterTheDictionaryIsASpace) {
  EXPECT_EQ(read("6:3:1", steps({1, 5, 4}, 6)).text, "a z");
  EXPECT_EQ(read("5:3:1", steps({1, 3, 4}, 5)).text, "a\xE6\xBC\xA2z") << "without space";
}

TEST(TextResults, ABatchMayBeTheMiddleDimension) {
  EXPECT_EQ(read("6:1:3", steps({1, 0, 1}, 6)).text, "aa");
}

TEST(TextResults, TheScoreIsTheMeanOfTheKeptCharacters) {
  auto values = steps({1, 1, 0, 4}, 6, 0.6f);
  const auto last = steps({4}, 6, 1);
  std::copy(last.begin(), last.end(), values.end() - 6);
  EXPECT_NEAR(read("6:4:1", values).score, 0.8, 1e-6);
}

TEST(TextResults, LogitsBecomeProbabilities) {
  // Softmax of (0, 3, -1, ...): e^3 / (e^3 + 1 + 4 / e).
  const auto found = read("6:1:1", {0, 3, -1, -1, -1, -1});
  EXPECT_EQ(found.text, "a") << found.error;
  EXPECT_NEAR(found.score, std::exp(3.0) / (std::exp(3.0) + 1 + 4 * std::exp(-1.0)), 1e-5);
}

TEST(TextResults, NothingToReadIsAnEmptyText) {
  for (const auto& values :
       {steps({0, 0, 0}, 6), steps({1, 2, 3}, 6, 0.4f), std::vector<float>(18, NAN)}) {
    const auto found = read("6:3:1", values);
    EXPECT_EQ(found.text, "") << found.error;
    EXPECT_EQ(found.score, 0);
  }
}

TEST(TextResults, StepsOfNaNAreBlank) {
  auto values = steps({1, 1, 1}, 6);
  std::fill(values.begin() + 6, values.begin() + 12, NAN);
  EXPECT_EQ(read("6:3:1", values).text, "aa");
}

TEST(TextResults, DictionariesMustFitTheModel) {
  const auto shorter = read("8:3:1", steps({1, 2, 3}, 8));
  EXPECT_SAYS(shorter.error, "the dictionary does not fit the model");
  EXPECT_SAYS(shorter.error, "offered: 4 characters");
  EXPECT_SAYS(shorter.error, "6 or 7 characters for 8 classes");
  EXPECT_SAYS(read("4:3:1", steps({1, 2, 3}, 4)).error, "2 or 3 characters for 4 classes");
  const auto none = read("6:3:1", steps({1, 2, 3}, 6), {});
  EXPECT_SAYS(none.error, "text recognition needs the model's dictionary");
  EXPECT_SAYS(none.error, "labels=/path/to/dictionary.txt");
}

TEST(TextResults, TheDictionaryMayBeInTheModel) {
  const TestTensor tensor("6:3:1", steps({4, 5, 1}, 6));
  const TestModel model{.metadata = R"({"custom_metadata_map": {"character": "a\nb\nc\nd"}})",
                        .input = "24:32:3:1"};
  ResultsRun run("text", {});
  ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
  run.decode({tensor});
  const auto& text = run.results.at(1).payload;
  EXPECT_EQ(std::string(text.begin(), text.end()), "d a");
}

TEST(TextResults, TextsOfRegionsBelongToTheirRows) {
  std::vector<float> batch;
  for (const auto& part : {steps({1, 2}, 6), steps({0, 0}, 6), steps({4, 0}, 6)})
    batch.insert(batch.end(), part.begin(), part.end());
  const TestTensor tensor("6:2:3", batch);
  SourceMap map;
  map.width = 16, map.height = 48;
  ResultsRun run("text", {{"labels", dictionary()}});
  ASSERT_TRUE(run.configure({tensor})) << run.error;
  run.decode({tensor}, {map, map, map}, true);
  ASSERT_EQ(run.n_rows(), 2u) << run.error;
  EXPECT_EQ(run.row(0).parent(), 0);
  EXPECT_EQ(run.row(1).parent(), 2);
  EXPECT_EQ(run.results[1].spec.shape, (Shape{3, 2}));
  EXPECT_EQ(run.results[1].payload, (Bytes{'a', 0xC3, 0xA9, 'z', 0, 0}));
}

TEST(TextResults, WhatMayBeAMapOrStepsNeedsAName) {
  // A map of a picture of unknown size, or 64 steps of 32 classes.
  const TestTensor tensor("32:64:1", std::vector<float>(32 * 64));
  const auto columns = [&](const std::string& name, const DecoderOptions& options) {
    const TestModel model{.input = "0:0:3:1", .names = {name}};
    ResultsRun run("text", options);
    run.configure({tensor}, &model);
    return run.error + run.caps;
  };
  const std::string labels =
      file_with("text-31.txt",
                "0\n1\n2\n3\n4\n5\n6\n7\n8\n9\na\nb\nc\nd\ne\nf\ng\nh\ni\nj\nk\nl\nm\nn\n"
                "o\np\nq\nr\ns\nt\nu\n");
  EXPECT_SAYS(columns("", {}), "the outputs fit several heads: ctc, db");
  EXPECT_SAYS(columns("", {}), "tensor_decoder custom=head:ctc or tensor_decoder custom=head:db");
  EXPECT_SAYS(columns("sigmoid_0.tmp_0", {}), "rotation");
  EXPECT_SAYS(columns("", {{"labels", labels}}), ";text");
  EXPECT_SAYS(columns("softmax_0.tmp_0", {{"labels", labels}}), ";text");
  EXPECT_SAYS(columns("", {{"head", "db"}}), "rotation");
}

}  // namespace text_results_test
}  // namespace weir::decoders
