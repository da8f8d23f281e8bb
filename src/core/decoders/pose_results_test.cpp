// Tests of persons: MoveNet, PoseNet's tensors and heat maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/decoders/results_test_support.hpp"

namespace weir::decoders {
namespace pose_results_test {

// y, x, score of 17 points.
std::vector<float> person(float x, float y, float score) {
  std::vector<float> out;
  for (int i = 0; i < 17; ++i)
    for (const float value : {y + 0.01f * static_cast<float>(i), x, score}) out.push_back(value);
  return out;
}

TEST(PoseResults, MovenetPointsArePartsOfThePicture) {
  auto values = person(0.5f, 0.25f, 0.8f);
  values[2] = 0.1f;  // the nose, outside the box of sure points
  values[0] = 0;
  const TestTensor tensor("3:17:1:1", values);
  const TestModel model{.input = "3:200:100:1"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
  run.decode({tensor});
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  ASSERT_EQ(run.row(0).n_points(), 17u);
  EXPECT_NEAR(run.row(0).score(), (16 * 0.8 + 0.1) / 17, 1e-6);
  EXPECT_NEAR(run.row(0).x(3), 100, 1e-4);
  EXPECT_NEAR(run.row(0).y(3), 28, 1e-4);
  EXPECT_NEAR(run.row(0).box().y1, 26, 1e-4);
  EXPECT_NEAR(run.row(0).box().y2, 41, 1e-4);
}

TEST(PoseResults, NoPersonIsFoundBelowTheThreshold) {
  const TestTensor tensor("3:17:1:1", person(0.5f, 0.25f, 0.3f));
  const TestModel model{.input = "3:200:100:1"};
  for (const auto& [threshold, is_there] : {std::pair("0.29", true), std::pair("0.31", false)}) {
    ResultsRun run("pose", {{"threshold", threshold}});
    ASSERT_TRUE(run.configure({tensor}, &model));
    run.decode({tensor});
    EXPECT_EQ(!run.row(0).is_background(), is_there) << threshold;
  }
}

TEST(PoseResults, MultiposePersonsHaveBoxes) {
  std::vector<float> values;
  for (int i = 0; i < 6; ++i) {
    const auto points = person(0.1f * static_cast<float>(i), 0.2f, 0.5f);
    values.insert(values.end(), points.begin(), points.end());
    // ymin, xmin, ymax, xmax, score
    for (const float value : {0.1f, 0.2f, 0.5f, 0.6f, i == 4 ? 0.9f : i == 2 ? 0.6f : 0.1f})
      values.push_back(value);
  }
  const TestTensor tensor("56:6:1", values);
  const TestModel model{.input = "3:100:200:1"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
  run.decode({tensor});
  ASSERT_EQ(run.n_rows(), 2u) << run.error;
  EXPECT_EQ(run.row(0).score(), 0.9f);
  EXPECT_NEAR(run.row(0).box().x1, 20, 1e-4);
  EXPECT_NEAR(run.row(0).box().y1, 20, 1e-4);
  EXPECT_NEAR(run.row(0).box().x2, 60, 1e-4);
  EXPECT_NEAR(run.row(0).box().y2, 100, 1e-4);
  EXPECT_NEAR(run.row(0).x(0), 40, 1e-4);
  EXPECT_NEAR(run.row(1).x(0), 20, 1e-4);
}

TEST(PoseResults, AHundredThousandPersonsAreCutToTheBest) {
  std::vector<float> values;
  for (int i = 0; i < 100000; ++i)
    for (int k = 0; k < 56; ++k) values.push_back(k == 55 ? static_cast<float>(i) / 100000 : 0.5f);
  const TestTensor tensor("56:100000:1", values);
  ResultsRun run("pose", {{"max-results", "5"}});
  const TestModel model{.input = "3:100:200:1"};
  ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
  run.decode({tensor});
  ASSERT_EQ(run.n_rows(), 5u);
  EXPECT_EQ(run.row(0).score(), 0.99999f);
}

TEST(PoseResults, NumbersThatAreNotFiniteAreNoPerson) {
  const TestModel model{.input = "3:100:200:1"};
  for (const float value : {NAN, -INFINITY}) {
    for (const auto& [shape, count] : {std::pair("3:17:1:1", 51), std::pair("56:6:1", 336),
                                       std::pair("25:50:17:1", 25 * 50 * 17)}) {
      const TestTensor tensor(shape, std::vector<float>(static_cast<size_t>(count), value));
      ResultsRun run("pose", {});
      ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
      run.decode({tensor});
      ASSERT_EQ(run.n_rows(), 1u) << run.error;
      EXPECT_TRUE(run.row(0).is_background()) << shape << value;
    }
  }
}

TEST(PoseResults, MovenetWithoutASizeOfTheInputIsRefused) {
  const TestTensor tensor("3:17:1:1", person(0.5f, 0.25f, 0.8f));
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure({tensor}));
  run.decode({tensor});
  EXPECT_SAYS(run.error, "the size of the model's input is not known");
  ResultsRun with_input("pose", {{"input", "100:100"}});
  ASSERT_TRUE(with_input.configure({tensor}));
  with_input.decode({tensor});
  EXPECT_NEAR(with_input.row(0).x(3), 50, 1e-4);
}

// Peaks of a Gaussian whose centres lie between cells.
struct Peak {
  float x, y, height;
};
const std::vector<Peak> kPeaks{{10.3f, 20.7f, 0.9f}, {30, 5, 0.5f}, {0, 31, 0.7f}};

float heat(const Peak& peak, size_t x, size_t y) {
  const float dx = static_cast<float>(x) - peak.x, dy = static_cast<float>(y) - peak.y;
  return peak.height * std::exp(-(dx * dx + dy * dy) / 8);
}

void expect_peaks(ResultsRun& run) {
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  ASSERT_EQ(run.row(0).n_points(), 3u);
  // Cells of 4 pixels. The quarter of a cell goes to where the centre is.
  EXPECT_EQ(run.row(0).x(0), 41);
  EXPECT_EQ(run.row(0).y(0), 83);
  EXPECT_EQ(run.row(0).x(1), 120) << "equal neighbours";
  EXPECT_EQ(run.row(0).y(1), 20);
  EXPECT_EQ(run.row(0).x(2), 0) << "no neighbour beyond the edge";
  EXPECT_EQ(run.row(0).y(2), 124);
  EXPECT_EQ(run.row(0).point_score(1), 0.5f);
}

TEST(PoseResults, HeatMapsMayBePlanarOrPacked) {
  std::vector<float> planar, packed;
  for (const Peak& peak : kPeaks)
    for (size_t y = 0; y < 32; ++y)
      for (size_t x = 0; x < 48; ++x) planar.push_back(heat(peak, x, y));
  for (size_t y = 0; y < 32; ++y)
    for (size_t x = 0; x < 48; ++x)
      for (const Peak& peak : kPeaks) packed.push_back(heat(peak, x, y));
  const TestModel model{.input = "3:192:128:1"};
  for (const auto& tensor : {TestTensor("48:32:3:1", planar), TestTensor("3:48:32:1", packed)}) {
    ResultsRun run("pose", {});
    ASSERT_TRUE(run.configure({tensor}, &model)) << run.error;
    run.decode({tensor});
    expect_peaks(run);
  }
}

TEST(PoseResults, HeatMapsOfOtherProportionsAreRefused) {
  const TestTensor tensor("48:32:3:1", std::vector<float>(48 * 32 * 3));
  const TestModel model{.input = "3:192:192:1"};
  ResultsRun run("pose", {{"head", "heat-maps"}});
  EXPECT_FALSE(run.configure({tensor}, &model));
  EXPECT_SAYS(run.error, "the outputs are not those of the head heat-maps");
  EXPECT_SAYS(run.error, "float32 48:32:3");
}

// PoseNet's tensors of a picture of 33 x 49 pixels: 3 x 4 cells, 16 pixels apart.
TEST(PoseResults, PosenetWithoutVectorsFindsTheBestPerson) {
  std::vector<float> heat(3 * 4 * 17, -5), offsets(3 * 4 * 34);
  for (size_t point = 0; point < 17; ++point) {
    const size_t cell = point % 12;
    heat[cell * 17 + point] = 2;
    offsets[cell * 34 + point] = 1.5f;        // y
    offsets[cell * 34 + 17 + point] = -2.5f;  // x
  }
  const std::vector<TestTensor> tensors{TestTensor("34:3:4:1", offsets),
                                        TestTensor("17:3:4:1", heat)};
  const TestModel model{.input = "3:33:49:1"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors);
  ASSERT_EQ(run.n_rows(), 1u) << run.error;
  EXPECT_NEAR(run.row(0).score(), 1 / (1 + std::exp(-2.0)), 1e-5);
  for (uint32_t point = 0; point < 17; ++point) {
    EXPECT_EQ(run.row(0).x(point), static_cast<float>(point % 12 % 3) * 16 - 2.5f);
    EXPECT_EQ(run.row(0).y(point), static_cast<float>(point % 12 / 3) * 16 + 1.5f);
  }
}

TEST(PoseResults, PosenetVectorsMayComeInOneTensorOrInTwo) {
  const std::vector<float> heat(3 * 4 * 17, 3), offsets(3 * 4 * 34), both(3 * 4 * 64),
      one(3 * 4 * 32);
  const TestModel model{.input = "3:33:49:1"};
  const std::vector<std::vector<TestTensor>> cases{
      {TestTensor("17:3:4:1", heat), TestTensor("34:3:4:1", offsets), TestTensor("64:3:4:1", both)},
      {TestTensor("17:3:4:1", heat), TestTensor("34:3:4:1", offsets), TestTensor("32:3:4:1", one),
       TestTensor("32:3:4:1", one)}};
  for (const auto& tensors : cases) {
    ResultsRun run("pose", {});
    ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
    run.decode(tensors);
    // Points without vectors stay where they are: a person starts from each place 20 pixels apart.
    EXPECT_GT(run.n_rows(), 1u) << run.error;
  }
}

}  // namespace pose_results_test
}  // namespace weir::decoders
