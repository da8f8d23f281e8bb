// Average precision of cases that can be computed on paper.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/average_precision.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/evaluate/similarity.hpp"

namespace weir::evaluate {
namespace average_precision_test {

TruthObject truth(const Rectangle& box, size_t category = 0) {
  return {category, box, box.area(), false, false, {}};
}
FoundObject found(const Rectangle& box, double score, size_t category = 0) {
  return {category, box, score, {}};
}
Rectangle square(double x, double side = 50) {
  return {x, 0, side, side};
}

double score(const Scores& scores, const std::string& name) {
  for (const Score& one : scores)
    if (one.name == name) return one.value;
  ADD_FAILURE() << "no score " << name;
  return 0;
}

Scores scores(const std::vector<PictureObjects>& pictures, size_t categories = 1) {
  return AveragePrecision(pictures, categories, {}).scores();
}

TEST(AveragePrecision, OfAPerfectDetectorIsOne) {
  const auto all = scores(
      {{{truth(square(0)), truth(square(200))}, {found(square(0), 0.9), found(square(200), 0.2)}}});
  for (const char* name : {"AP", "AP50", "AP75", "AP medium", "AR 10", "AR 100"})
    EXPECT_DOUBLE_EQ(score(all, name), 1) << name;
  EXPECT_DOUBLE_EQ(score(all, "AR 1"), 0.5);  // one of the two
  EXPECT_TRUE(std::isnan(score(all, "AP small")));
  EXPECT_TRUE(std::isnan(score(all, "AP large")));
}

TEST(AveragePrecision, InterpolatesAt101Recalls) {
  // Hit, false, hit: precision is 1 up to a recall of 0.50, which are 51 of 101, then 2/3.
  const auto all =
      scores({{{truth(square(0)), truth(square(200))},
               {found(square(0), 0.9), found(square(400), 0.8), found(square(200), 0.7)}}});
  EXPECT_NEAR(score(all, "AP"), (51 + 50 * 2.0 / 3) / 101, 1e-12);
}

TEST(AveragePrecision, OfAPublishedExample) {
  // R. Padilla, S. L. Netto, E. A. B. da Silva, "A Survey on Performance Metrics for
  // Object-Detection Algorithms", IWSSIP 2020: 15 objects in seven pictures, 24 boxes, seven hits.
  struct Box {
    size_t picture;
    double score;
    bool is_hit;
  };
  constexpr Box kBoxes[] = {{1, .88, false}, {1, .70, true},  {1, .80, false}, {2, .71, false},
                            {2, .54, true},  {2, .74, false}, {3, .18, true},  {3, .67, false},
                            {3, .38, false}, {3, .91, true},  {3, .44, false}, {4, .35, false},
                            {4, .78, false}, {4, .45, false}, {4, .14, false}, {5, .62, true},
                            {5, .44, false}, {5, .95, true},  {5, .23, false}, {6, .45, false},
                            {6, .84, false}, {6, .43, false}, {7, .48, true},  {7, .95, false}};
  std::vector<PictureObjects> pictures(7);
  double x = 0;
  for (const Box& box : kBoxes) {
    PictureObjects& picture = pictures[box.picture - 1];
    picture.found.push_back(found(square(x), box.score));
    if (box.is_hit) picture.truth.push_back(truth(square(x)));
    x += 100;
  }
  for (int missed = 0; missed < 8; ++missed, x += 100)
    pictures[3].truth.push_back(truth(square(x)));
  const AveragePrecision precision(pictures, 1, {});
  const auto curve = precision.curve_of_category(0);
  double eleven = 0;
  for (size_t recall = 0; recall <= 100; recall += 10) eleven += curve[recall] / 11;
  EXPECT_NEAR(eleven, 0.2684, 0.00005);  // the paper's mean at eleven recalls
  // At 101 recalls, of the precisions of the paper's curve.
  EXPECT_NEAR(score(precision.scores(), "AP"),
              (7 * 1 + 7 * 2.0 / 3 + 27 * 3.0 / 7 + 6 * 7.0 / 23) / 101, 1e-12);
}

TEST(AveragePrecision, CountsEachThresholdOfOverlap) {
  // 36 of 50 columns overlap: an IoU of 0.72 meets .50 to .70, five of the ten.
  const auto all = scores({{{truth({0, 0, 50, 50})}, {found({0, 0, 36, 50}, 0.5)}}});
  EXPECT_NEAR(score(all, "AP"), 0.5, 1e-12);
  EXPECT_NEAR(score(all, "AP50"), 1, 1e-12);
  EXPECT_NEAR(score(all, "AP75"), 0, 1e-12);
}

TEST(AveragePrecision, IsTheMeanOfTheCategoriesWithTruth) {
  const auto all = scores({{{truth(square(0), 0), truth(square(200), 1)},
                            {found(square(0), 0.9, 0), found(square(0), 0.9, 2)}}},
                          3);
  EXPECT_DOUBLE_EQ(score(all, "AP"), 0.5);  // 1 and 0; the third category has no truth
}

TEST(AveragePrecision, ASecondBoxOfAnObjectIsFalse) {
  const auto all = scores({{{truth(square(0))}, {found(square(0), 0.8), found(square(0), 0.9)}}});
  EXPECT_DOUBLE_EQ(score(all, "AP"), 1);  // it comes after the hit
  const auto two =
      scores({{{truth(square(0)), truth(square(200))},
               {found(square(0), 0.9), found(square(0), 0.8), found(square(200), 0.7)}}});
  EXPECT_NEAR(score(two, "AP"), (51 + 50 * 2.0 / 3) / 101, 1e-12);
}

TEST(AveragePrecision, CrowdsTakeAnyNumberOfBoxes) {
  TruthObject crowd = truth({200, 0, 400, 400});
  crowd.is_crowd = true;
  PictureObjects picture{{truth(square(0)), crowd}, {}};
  for (double x = 200; x < 400; x += 50) picture.found.push_back(found(square(x), 0.95));
  picture.found.push_back(found(square(0), 0.5));
  EXPECT_DOUBLE_EQ(score(scores({picture}), "AP"), 1);
  picture.truth[1].is_crowd = false;  // four false boxes before the hit
  picture.truth.pop_back();
  EXPECT_NEAR(score(scores({picture}), "AP"), 1.0 / 5, 1e-12);
}

TEST(AveragePrecision, IgnoredObjectsTakeOneBox) {
  TruthObject ignored = truth(square(200));
  ignored.is_ignored = true;
  PictureObjects picture{{truth(square(0)), ignored},
                         {found(square(200), 0.9), found(square(0), 0.5)}};
  EXPECT_DOUBLE_EQ(score(scores({picture}), "AP"), 1);
  picture.found.push_back(found(square(200), 0.8));
  EXPECT_NEAR(score(scores({picture}), "AP"), 0.5, 1e-12);
}

TEST(AveragePrecision, RangesOfAreasLeaveOthersOut) {
  // A small object that is found and a large one that is not.
  const auto all = scores({{{truth(square(0, 20)), truth(square(200, 100))},
                            {found(square(0, 20), 0.9), found({900, 0, 100, 100}, 0.95)}}});
  EXPECT_DOUBLE_EQ(score(all, "AP small"), 1);
  EXPECT_DOUBLE_EQ(score(all, "AP large"), 0);
  EXPECT_DOUBLE_EQ(score(all, "AR small"), 1);
  EXPECT_TRUE(std::isnan(score(all, "AP medium")));
}

TEST(AveragePrecision, UsesTheHundredBestBoxesOfAPicture) {
  PictureObjects picture{{truth(square(0))}, {}};
  for (int i = 0; i < 99; ++i) picture.found.push_back(found(square(1000), 0.9));
  picture.found.push_back(found(square(0), 0.5));
  EXPECT_NEAR(score(scores({picture}), "AP"), 0.01, 1e-12);
  picture.found.push_back(found(square(1000), 0.9));
  EXPECT_DOUBLE_EQ(score(scores({picture}), "AP"), 0);
}

TEST(AveragePrecision, WithoutTruthIsUndefined) {
  const auto all = scores({{{}, {found(square(0), 0.9)}}});
  for (const Score& one : all) EXPECT_TRUE(std::isnan(one.value)) << one.name;
  const AveragePrecision precision(std::vector<PictureObjects>{{{}, {}}}, 1, {});
  EXPECT_TRUE(std::isnan(precision.of_category(0)));
}

TEST(AveragePrecision, WithoutFoundObjectsIsZero) {
  EXPECT_DOUBLE_EQ(score(scores({{{truth(square(0))}, {}}}), "AP"), 0);
}

TEST(AveragePrecision, OfPicturesThatCountSeveralTimes) {
  const std::vector<PictureObjects> pictures{{{truth(square(0))}, {found(square(0), 0.9)}},
                                             {{truth(square(0))}, {found(square(200), 0.95)}}};
  std::vector<PictureObjects> twice = pictures;
  twice.push_back(pictures[0]);
  const std::vector<uint32_t> times{2, 1};
  const AveragePrecision weighted(pictures, 1, {});
  EXPECT_DOUBLE_EQ(weighted.headline(times)[0].value, score(scores(twice), "AP"));
  const std::vector<uint32_t> first{1, 0};
  EXPECT_DOUBLE_EQ(weighted.headline(first)[0].value, 1);
}

TEST(AveragePrecision, CurveFallsFromTheFirstHits) {
  const std::vector<PictureObjects> pictures{
      {{truth(square(0)), truth(square(200))},
       {found(square(0), 0.9), found(square(400), 0.8), found(square(200), 0.7)}}};
  const auto curve = AveragePrecision(pictures, 1, {}).curve_of_category(0);
  EXPECT_DOUBLE_EQ(curve[50], 1);
  EXPECT_DOUBLE_EQ(curve[51], 2.0 / 3);
  EXPECT_DOUBLE_EQ(curve[100], 2.0 / 3);
}

TruthObject person(double x) {
  TruthObject out = truth({x, 0, 100, 100});
  for (int i = 0; i < 17; ++i) out.points.push_back({x + 50, i * 5.0, true});
  return out;
}
FoundObject found_person(double x, double shift, double score) {
  FoundObject out = found({x, 0, 100, 100}, score);
  for (int i = 0; i < 17; ++i) out.points.push_back({x + 50 + shift, i * 5.0, true});
  return out;
}

TEST(KeyPointSimilarity, SimilarityIsThatOfItsDefinition) {
  const auto deviations = key_point_deviations(17);
  EXPECT_DOUBLE_EQ(key_point_similarity(person(0), found_person(0, 0, 1), deviations), 1);
  double expected = 0;
  for (const double sigma : deviations)
    expected += std::exp(-(7.0 * 7) / (2 * 100 * 100 * (2 * sigma) * (2 * sigma))) / 17;
  EXPECT_NEAR(key_point_similarity(person(0), found_person(0, 7, 1), deviations), expected, 1e-12);
}

TEST(KeyPointSimilarity, PointsWithoutLabelDoNotCount) {
  TruthObject object = person(0);
  FoundObject other = found_person(0, 0, 1);
  other.points[3].x += 1000;
  const auto deviations = key_point_deviations(17);
  EXPECT_NEAR(key_point_similarity(object, other, deviations), 16.0 / 17, 1e-12);
  object.points[3].is_labelled = false;
  EXPECT_DOUBLE_EQ(key_point_similarity(object, other, deviations), 1);
  other.points[4].is_labelled = false;  // not found
  EXPECT_NEAR(key_point_similarity(object, other, deviations), 15.0 / 16, 1e-12);
}

TEST(KeyPointSimilarity, HaveTenScores) {
  const std::vector<PictureObjects> pictures{{{person(0)}, {found_person(0, 0, 0.9)}}};
  const auto all = AveragePrecision(pictures, 1, {key_point_deviations(17)}).scores();
  EXPECT_EQ(all.size(), 10U);
  for (const char* name : {"AP", "AP50", "AR", "AP large", "AR75"})
    EXPECT_DOUBLE_EQ(score(all, name), 1) << name;
}

TEST(KeyPointSimilarity, OtherNumbersOfPointsHaveEqualDeviations) {
  EXPECT_EQ(key_point_deviations(5), std::vector<double>(5, 0.2));
  EXPECT_EQ(key_point_deviations(17)[0], 0.026);
}

}  // namespace average_precision_test
}  // namespace weir::evaluate
