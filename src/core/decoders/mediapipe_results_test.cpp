// Tests of MediaPipe's networks: tensors are encoded from the published graphs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <numbers>

#include "core/decoders/results_test_support.hpp"

namespace weir::decoders {
namespace mediapipe_results_test {

constexpr float kPi = std::numbers::pi_v<float>;

struct Detector {
  std::string head, input;
  size_t anchors, points;
};
const Detector kFace{"blazeface", "3:128:128:1", 896, 6};
const Detector kPalm{"palm-detection", "3:192:192:1", 2016, 7};
const Detector kPalm256{"palm-detection", "3:256:256:1", 2944, 7};
const Detector kPose{"blazepose-detection", "3:224:224:1", 2254, 4};

// An object in pixels, at an anchor whose centre is given.
struct Found {
  size_t anchor;
  float anchor_x, anchor_y;
  float logit;
  Box box;
  std::vector<float> points;
};

std::vector<TestTensor> encode(const Detector& detector, const std::vector<Found>& all) {
  const size_t length = 4 + 2 * detector.points;
  std::vector<float> values(detector.anchors * length), scores(detector.anchors, -20.0f);
  for (const auto& found : all) {
    float* row = values.data() + found.anchor * length;
    scores[found.anchor] = found.logit;
    row[0] = (found.box.x1 + found.box.x2) / 2 - found.anchor_x;
    row[1] = (found.box.y1 + found.box.y2) / 2 - found.anchor_y;
    row[2] = found.box.width(), row[3] = found.box.height();
    for (size_t i = 0; i < found.points.size(); ++i)
      row[4 + i] = found.points[i] - (i % 2 == 0 ? found.anchor_x : found.anchor_y);
  }
  const std::string count = std::to_string(detector.anchors);
  return {TestTensor(std::to_string(length) + ":" + count + ":1", values),
          TestTensor("1:" + count + ":1", scores)};
}

void expect_box(const Box& box, const Box& wanted) {
  EXPECT_NEAR(box.x1, wanted.x1, 1e-3);
  EXPECT_NEAR(box.y1, wanted.y1, 1e-3);
  EXPECT_NEAR(box.x2, wanted.x2, 1e-3);
  EXPECT_NEAR(box.y2, wanted.y2, 1e-3);
}

struct Place {
  const Detector& detector;
  Found found;
};

TEST(MediapipeResults, AnchorsAreWhereTheGraphsPutThem) {
  const std::vector<float> points{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  const auto first = [&](size_t count) {
    return std::vector(points.begin(), points.begin() + static_cast<ptrdiff_t>(2 * count));
  };
  const std::vector<Place> places{
      // Two anchors in each of 16 x 16 cells of 8 pixels, then six in each of 8 x 8 of 16.
      {kFace, {2 * (5 * 16 + 3) + 1, 28, 44, 3, {10, 20, 40, 60}, first(6)}},
      {kFace, {512 + 6 * (7 * 8 + 2) + 5, 40, 120, 3, {30, 70, 80, 125}, first(6)}},
      {kPalm, {2 * (23 * 24 + 1), 12, 188, 3, {2, 150, 40, 190}, first(7)}},
      {kPalm, {1152 + 6 * (11 * 12 + 11) + 3, 184, 184, 3, {150, 150, 190, 190}, first(7)}},
      {kPalm256, {2048 + 2 * (4 * 16 + 9), 152, 72, 3, {100, 40, 180, 120}, first(7)}},
      {kPalm256, {2048 + 512 + 6 * (6 * 8 + 4), 144, 208, 3, {90, 100, 250, 250}, first(7)}}};
  for (const auto& [detector, found] : places) {
    const TestModel model{.input = detector.input};
    ResultsRun run("detection", {});
    const auto tensors = encode(detector, {found});
    ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
    run.decode(tensors);
    ASSERT_EQ(run.n_rows(), 1u) << run.error;
    expect_box(run.row(0).box(), found.box);
    EXPECT_NEAR(run.row(0).score(), 1 / (1 + std::exp(-3.0)), 1e-6);
    ASSERT_EQ(run.row(0).n_points(), detector.points);
    for (uint32_t i = 0; i < detector.points; ++i) {
      EXPECT_NEAR(run.row(0).x(i), found.points[2 * i], 1e-3);
      EXPECT_NEAR(run.row(0).y(i), found.points[2 * i + 1], 1e-3);
    }
  }
}

TEST(MediapipeResults, TheBackCameraHasTheAnchorsOfTheFrontOne) {
  // 896 anchors of a picture of 256 pixels: cells of 16 and 32 pixels.
  const Detector back{"blazeface", "3:256:256:1", 896, 6};
  const Found found{2 * (5 * 16 + 3), 56, 88, 2, {10, 20, 90, 100}, std::vector<float>(12, 50)};
  const TestModel model{.input = back.input};
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure(encode(back, {found}), &model));
  run.decode(encode(back, {found}));
  expect_box(run.row(0).box(), found.box);
}

// The palm at an angle: key point 0 is the wrist, key point 2 the knuckle of the middle finger.
float palm_rotation(float x, float y) {
  std::vector<float> points(14, 96.0f);
  points[4] = 96 + x, points[5] = 96 + y;
  const Found found{2 * (12 * 24 + 12), 100, 100, 3, {76, 76, 116, 116}, points};
  const TestModel model{.input = kPalm.input};
  ResultsRun run("detection", {});
  EXPECT_TRUE(run.configure(encode(kPalm, {found}), &model));
  run.decode(encode(kPalm, {found}));
  expect_box(run.row(0).box(), found.box);
  return run.row(0).rotation();
}

TEST(MediapipeResults, APalmIsTurnedLikeItsMiddleFinger) {
  EXPECT_NEAR(palm_rotation(0, -10), 0, 1e-6);
  EXPECT_NEAR(palm_rotation(10, 0), kPi / 2, 1e-6);
  EXPECT_NEAR(palm_rotation(-10, 0), -kPi / 2, 1e-6);
  EXPECT_NEAR(palm_rotation(10, -10), kPi / 4, 1e-6);
  EXPECT_NEAR(std::abs(palm_rotation(0, 10)), kPi, 1e-6);
  EXPECT_EQ(palm_rotation(0, 0), 0);
}

TEST(MediapipeResults, APersonIsTheSquareAroundTheHips) {
  // Key point 1 is on the circle around the person: 60 right of and 80 above the hips.
  const Found found{0, 4, 4, 3, {90, 20, 130, 60}, {110, 120, 170, 40, 0, 0, 0, 0}};
  const TestModel model{.input = kPose.input};
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure(encode(kPose, {found}), &model)) << run.error;
  run.decode(encode(kPose, {found}));
  ASSERT_EQ(run.n_rows(), 1u);
  expect_box(run.row(0).box(), {10, 20, 210, 220});
  EXPECT_NEAR(run.row(0).rotation(), std::atan2(60.0, 80.0), 1e-5);
}

TEST(MediapipeResults, RotatedBoxesTurnWithThePicture) {
  // The source picture is the input, turned by 90 degrees clockwise and twice as large.
  SourceMap map;
  map.xx = 0, map.xy = -2, map.x0 = 400;
  map.yx = 2, map.yy = 0, map.y0 = 0;
  map.width = map.height = 192;
  std::vector<float> points(14, 96.0f);
  points[5] = 86;
  const Found found{2 * (12 * 24 + 12), 100, 100, 3, {86, 66, 106, 106}, points};
  const TestModel model{.input = kPalm.input};
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure(encode(kPalm, {found}), &model));
  run.decode(encode(kPalm, {found}), {map});
  // Centre (96, 86) becomes (400 - 172, 192); the box keeps its width of 2 * 20.
  expect_box(run.row(0).box(), {208, 152, 248, 232});
  EXPECT_NEAR(run.row(0).rotation(), kPi / 2, 1e-5);
}

TEST(MediapipeResults, LogitsDecideBetweenCertainBoxes) {
  // Both probabilities are 1 in float32.
  const Found good{2 * (5 * 16 + 3) + 1, 28, 44, 40, {10, 20, 40, 60}, std::vector<float>(12)};
  const Found weaker{2 * (5 * 16 + 3), 28, 44, 30, {12, 20, 42, 60}, std::vector<float>(12)};
  const TestModel model{.input = kFace.input};
  ResultsRun run("detection", {});
  ASSERT_TRUE(run.configure(encode(kFace, {good, weaker}), &model));
  run.decode(encode(kFace, {good, weaker}));
  ASSERT_EQ(run.n_rows(), 1u);
  expect_box(run.row(0).box(), good.box);
}

TEST(MediapipeResults, DetectorsIgnoreNumbersThatAreNotFinite) {
  for (const Detector& detector : {kFace, kPalm, kPose})
    for (const float value : {NAN, INFINITY, -INFINITY}) {
      auto tensors = encode(detector, {});
      for (auto& tensor : tensors)
        for (size_t i = 0; i < tensor.bytes.size(); i += sizeof value)
          std::memcpy(tensor.bytes.data() + i, &value, sizeof value);
      const TestModel model{.input = detector.input};
      ResultsRun run("detection", {});
      ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
      run.decode(tensors);
      ASSERT_EQ(run.n_rows(), 1u) << run.error;
      EXPECT_TRUE(run.row(0).is_background()) << value;
    }
}

TEST(MediapipeResults, OtherNumbersOfAnchorsAreRefused) {
  const Detector odd{"palm-detection", "3:192:192:1", 2017, 7};
  ResultsRun run("detection", {{"head", "palm-detection"}});
  const TestModel model{.input = odd.input};
  EXPECT_FALSE(run.configure(encode(odd, {}), &model));
  EXPECT_SAYS(run.error, "the outputs are not those of the head palm-detection");
  EXPECT_SAYS(run.error, "N = 2016 or 2944");
}

std::vector<float> sequence(size_t count) {
  std::vector<float> out(count);
  for (size_t i = 0; i < count; ++i) out[i] = static_cast<float>(i);
  return out;
}

TEST(MediapipeResults, AHandHasASide) {
  const TestModel model{.input = "3:224:224:1",
                        .names = {"Identity_3", "Identity_2", "Identity", "Identity_1"}};
  for (const float right : {0.1f, 0.8f}) {
    // In another order than the published one; the world's coordinates come last there.
    const std::vector<TestTensor> tensors{
        TestTensor("63:1", std::vector<float>(63, 0.01f)), TestTensor("1:1", {right}),
        TestTensor("63:1", sequence(63)), TestTensor("1:1", std::vector<float>{0.9f})};
    ResultsRun run("pose", {});
    ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
    run.decode(tensors);
    ASSERT_EQ(run.n_rows(), 1u) << run.error;
    EXPECT_EQ(run.row(0).score(), 0.9f);
    EXPECT_EQ(run.row(0).class_index(), right > 0.5f ? 1 : 0);
    ASSERT_EQ(run.row(0).n_points(), 21u);
    EXPECT_EQ(run.row(0).x(20), 60);
    EXPECT_EQ(run.row(0).y(20), 61);
    EXPECT_EQ(run.row(0).box(), (Box{0, 1, 60, 61}));
  }
}

TEST(MediapipeResults, ThePresenceOfAFaceIsALogit) {
  const TestModel model{.input = "3:192:192:1"};
  for (const float logit : {-2.0f, 2.0f, NAN}) {
    const std::vector<TestTensor> tensors{TestTensor("1404:1:1:1", sequence(1404)),
                                          TestTensor("1:1:1:1", std::vector<float>{logit})};
    ResultsRun run("pose", {});
    ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
    run.decode(tensors);
    ASSERT_EQ(run.n_rows(), 1u) << run.error;
    EXPECT_EQ(run.row(0).n_points(), 468u);
    if (logit == 2)
      EXPECT_NEAR(run.row(0).score(), 0.880797, 1e-5);
    else
      EXPECT_TRUE(run.row(0).is_background());
  }
}

TEST(MediapipeResults, OfThirtyNinePointsOfABodySixAreAuxiliary) {
  std::vector<float> values(195);
  for (size_t i = 0; i < 39; ++i) {
    values[5 * i] = static_cast<float>(10 + i), values[5 * i + 1] = static_cast<float>(100 + i);
    values[5 * i + 3] = i < 10 ? 3.0f : -3.0f;  // visibility
  }
  const std::vector<TestTensor> tensors{TestTensor("195:1", values),
                                        TestTensor("1:1", std::vector<float>{0.75f}),
                                        TestTensor("1:16:16:1", std::vector<float>(256)),
                                        TestTensor("117:1", std::vector<float>(117))};
  const TestModel model{.input = "3:256:256:1"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors);
  ASSERT_EQ(run.row(0).n_points(), 33u);
  EXPECT_EQ(run.row(0).x(32), 42);
  EXPECT_NEAR(run.row(0).point_score(0), 0.952574, 1e-5);
  EXPECT_NEAR(run.row(0).point_score(32), 0.047426, 1e-5);
  EXPECT_EQ(run.row(0).box(), (Box{10, 100, 19, 109})) << "around the visible points";
}

TEST(MediapipeResults, LandmarksOfRegionsBelongToTheirRows) {
  std::vector<float> points = sequence(63), batch;
  for (int i = 0; i < 3; ++i) batch.insert(batch.end(), points.begin(), points.end());
  const std::vector<TestTensor> tensors{TestTensor("63:3", batch),
                                        TestTensor("1:3", std::vector<float>{0.9f, 0.2f, 0.8f}),
                                        TestTensor("1:3", std::vector<float>{0, 0, 1})};
  SourceMap map;
  map.width = map.height = 224;
  std::vector<SourceMap> maps(3, map);
  maps[2].x0 = 500, maps[2].xx = 2;
  const TestModel model{.input = "3:224:224:3"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors, maps, true);
  ASSERT_EQ(run.n_rows(), 2u) << run.error;
  EXPECT_EQ(run.row(0).parent(), 0);
  EXPECT_EQ(run.row(1).parent(), 2) << "the second region has no hand";
  EXPECT_EQ(run.row(1).class_index(), 1);
  EXPECT_EQ(run.row(1).x(20), 620);
  EXPECT_EQ(run.row(1).y(20), 61);
}

TEST(MediapipeResults, PointsThatAreNotFiniteHaveNoScore) {
  auto points = sequence(63);
  points[0] = NAN, points[3] = INFINITY;
  const std::vector<TestTensor> tensors{TestTensor("63:1", points),
                                        TestTensor("1:1", std::vector<float>{0.9f})};
  const TestModel model{.input = "3:224:224:1"};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure(tensors, &model));
  run.decode(tensors);
  EXPECT_EQ(run.row(0).point_score(0), 0);
  EXPECT_EQ(run.row(0).point_score(1), 0);
  EXPECT_EQ(run.row(0).point_score(2), 0.9f);
  EXPECT_EQ(run.row(0).box(), (Box{6, 7, 60, 61}));
}

TEST(MediapipeResults, LandmarksAreReadFromQuantisedTensors) {
  std::vector<uint8_t> points(63);
  for (size_t i = 0; i < 63; ++i) points[i] = static_cast<uint8_t>(100 + i);
  const std::vector<TestTensor> tensors{
      TestTensor(ElementType::UInt8, "63:1", points),
      TestTensor(ElementType::UInt8, "1:1", std::vector<uint8_t>{192})};
  const TestModel model{.input = "3:224:224:1", .scales = {2, 1 / 256.0f}, .zero_points = {100, 0}};
  ResultsRun run("pose", {});
  ASSERT_TRUE(run.configure(tensors, &model)) << run.error;
  run.decode(tensors);
  EXPECT_EQ(run.row(0).score(), 0.75f);
  EXPECT_EQ(run.row(0).x(1), 6);
}

}  // namespace mediapipe_results_test
}  // namespace weir::decoders
