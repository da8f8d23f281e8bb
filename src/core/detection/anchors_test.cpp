// Tests of heads that are relative to prior boxes and anchors; numbers from a calculation in NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "core/detection/anchors.hpp"
#include "says.hpp"

namespace weir::detection {
namespace anchors_test {

const float kNan = std::nanf("");

BoxPriors one_prior() {
  return *parse_box_priors("0.5\n0.25\n0.5\n0.125");
}
Candidates decode_one(std::vector<float> box, std::vector<float> scores, float threshold = 0.5f) {
  return decode({.boxes = box, .scores = scores, .classes = scores.size()}, one_prior(), {},
                threshold, {800, 400});
}

TEST(SsdPriors, ReadsFourLinesWithAnySeparators) {
  const auto priors = parse_box_priors("0.1 0.2,0.3\r\n1\t2 , 3 \n4 5 6\n7,8,9\n\n");
  ASSERT_TRUE(priors) << priors.error().message();
  EXPECT_EQ(priors->y, (std::vector<float>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(priors->x, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(priors->height, (std::vector<float>{4, 5, 6}));
  EXPECT_EQ(priors->width, (std::vector<float>{7, 8, 9}));
}

TEST(SsdPriors, RejectsEveryOtherText) {
  const std::pair<const char*, const char*> texts[] = {
      {"", "line 1 (y of the centres) has 0 values"},
      {"1 2\n3 4\n5 6", "there are 3 lines"},
      {"1 2\n3 4\n5 6\n7 8\n9 10", "there are more than four lines"},
      {"1 2\n3 4\n5\n7 8", "line 3 (heights) has 1 values, the first line 2"},
      {"1 2\n3 x4\n5 6\n7 8", "line 2 (x of the centres): \"x4\" is not a number"},
      {"1 nan\n3 4\n5 6\n7 8", "\"nan\" is not a number"},
      {"1 1e99\n3 4\n5 6\n7 8", "\"1e99\" is not a number"}};
  for (const auto& [text, difference] : texts) {
    const auto priors = parse_box_priors(text);
    ASSERT_FALSE(priors) << text;
    EXPECT_SAYS(priors.error().message(), "WEIR-1001: the file is not a list of prior boxes");
    EXPECT_SAYS(priors.error().message(), difference);
  }
}

TEST(SsdHead, AZeroBoxIsThePrior) {
  const auto found = decode_one({0, 0, 0, 0}, {9, -1, 0, -2});
  ASSERT_EQ(found.size(), 1u) << "logit(0.5) is 0";
  EXPECT_EQ(found[0], (Candidate{.x = 150,
                                 .y = 100,
                                 .width = 100,
                                 .height = 200,
                                 .score = 0.5f,
                                 .class_index = 2,
                                 .row = 0}));
}

// numpy: yc = 2/10*.5+.5; xc = -1/10*.125+.25; h = exp(.5/5)*.5; w = exp(1/5)*.125
TEST(SsdHead, MovesAndScalesThePrior) {
  const auto found = decode_one({2, -1, 0.5f, 1}, {0, 2});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].x, 128.92986, 1e-3);
  EXPECT_NEAR(found[0].y, 129.48291, 1e-3);
  EXPECT_NEAR(found[0].width, 122.14028, 1e-3);
  EXPECT_NEAR(found[0].height, 221.03418, 1e-3);
  EXPECT_NEAR(found[0].score, 0.880797, 1e-6);
}

TEST(SsdHead, TakesTheFirstOrTheBestClass) {
  const std::vector<float> box(4), scores{9, -1, 1, 3};
  const SsdHead head{.boxes = box, .scores = scores, .classes = 4};
  EXPECT_EQ(decode(head, one_prior(), {}, 0.5f, {8, 4})[0].class_index, 3);
  EXPECT_EQ(decode(head, one_prior(), {}, 0.5f, {8, 4}, SsdClass::First)[0].class_index, 2);
}

TEST(SsdHead, ThresholdsAtTheEndsAcceptAllOrNothing) {
  const float min = -std::numeric_limits<float>::max();
  EXPECT_EQ(decode_one({0, 0, 0, 0}, {0, min}, 0).size(), 1u);
  EXPECT_EQ(decode_one({0, 0, 0, 0}, {0, 1e30f}, 1).size(), 0u);
  EXPECT_EQ(decode_one({0, 0, 0, 0}, {0, INFINITY}, 1).size(), 1u);
}

TEST(SsdHead, LeavesOutWhatIsNotFinite) {
  EXPECT_TRUE(decode_one({0, 0, 0, 0}, {0, kNan}).empty());
  EXPECT_TRUE(decode_one({0, 0, 0, 0}, {0, kNan}, 0).empty()) << "a threshold that numbers reach";
  EXPECT_TRUE(decode_one({0, 0, 0, 0}, {9}).empty()) << "only background";
  EXPECT_TRUE(decode_one({kNan, 0, 0, 0}, {0, 1}).empty());
  EXPECT_TRUE(decode_one({0, 0, 1e4f, 0}, {0, 1}).empty()) << "exp(2000)";
}

TEST(PalmAnchors, TheUsualOnesAreThoseOfTheModel) {
  const auto anchors = make_palm_anchors({});
  ASSERT_EQ(anchors.size(), 2016u);  // 24 * 24 * 2 + 12 * 12 * 6
  EXPECT_EQ(anchors[0], (Anchor{0.5f / 24, 0.5f / 24, 1, 1}));
  EXPECT_EQ(anchors[1], anchors[0]);
  EXPECT_EQ(anchors[2], (Anchor{1.5f / 24, 0.5f / 24, 1, 1})) << "x runs before y";
  EXPECT_EQ(anchors[1152], (Anchor{0.5f / 12, 0.5f / 12, 1, 1})) << "the layers of stride 16";
  EXPECT_EQ(anchors[1158], (Anchor{1.5f / 12, 0.5f / 12, 1, 1}));
  EXPECT_EQ(anchors.back(), (Anchor{11.5f / 12, 11.5f / 12, 1, 1}));
}

TEST(PalmAnchors, EachLayerHasItsScaleAndTheNext) {
  const auto anchors = make_palm_anchors({.min_scale = 0.25f,
                                          .max_scale = 0.75f,
                                          .x_offset = 0,
                                          .y_offset = 1,
                                          .strides = {96, 96, 192}});
  // A grid of 2 x 2 cells with four anchors, then one cell with two.
  ASSERT_EQ(anchors.size(), 18u);
  EXPECT_EQ(anchors[0], (Anchor{0, 0.5f, 0.25f, 0.25f}));
  EXPECT_EQ(anchors[1], (Anchor{0, 0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(anchors[2], (Anchor{0, 0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(anchors[3], (Anchor{0, 0.5f, 0.75f, 0.75f}));
  EXPECT_EQ(anchors[4], (Anchor{0.5f, 0.5f, 0.25f, 0.25f}));
  EXPECT_EQ(anchors[16], (Anchor{0, 1, 0.75f, 0.75f}));
  EXPECT_EQ(anchors[17], (Anchor{0, 1, 1, 1}));
  const auto one = make_palm_anchors({.min_scale = 0.25f,
                                      .max_scale = 0.75f,
                                      .x_offset = 0.5f,
                                      .y_offset = 0.5f,
                                      .strides = {100}});
  ASSERT_EQ(one.size(), 8u) << "192 / 100 rounded up";
  EXPECT_EQ(one[0], (Anchor{0.25f, 0.25f, 0.5f, 0.5f}));
}

TEST(Palms, AreRelativeToTheirAnchor) {
  const std::vector<Anchor> anchors{{0.5f, 0.25f, 1, 1}, {0.5f, 0.5f, 0.5f, 0.5f}};
  std::vector<float> boxes(2 * kPalmRow);
  boxes[0] = 16, boxes[1] = -16, boxes[2] = 32, boxes[3] = 64;  // y, x, height, width
  const auto found = decode_palms(boxes, std::vector<float>{0, -1}, anchors, 0.5f, {128, 64});
  ASSERT_EQ(found.size(), 1u);
  // yc = 16/64 + .25 = .5; xc = -16/128 + .5 = .375; h = .5; w = .5
  EXPECT_EQ(
      found[0],
      (Candidate{
          .x = 16, .y = 16, .width = 64, .height = 32, .score = 0.5f, .class_index = 0, .row = 0}));
}

TEST(Palms, LeavesOutWhatIsNotFinite) {
  std::vector<float> boxes(kPalmRow);
  const std::vector<Anchor> anchors{{0.5f, 0.5f, 1, 1}};
  EXPECT_EQ(decode_palms(boxes, std::vector<float>{1e30f}, anchors, 1, {64, 64}).size(), 1u);
  EXPECT_TRUE(decode_palms(boxes, std::vector<float>{kNan}, anchors, 0, {64, 64}).empty());
  boxes[2] = INFINITY;
  EXPECT_TRUE(decode_palms(boxes, std::vector<float>{9}, anchors, 0.5f, {64, 64}).empty());
}

}  // namespace anchors_test
}  // namespace weir::detection
