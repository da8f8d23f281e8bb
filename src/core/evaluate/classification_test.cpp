// Accuracy and confusion of a few pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/classification.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace weir::evaluate {
namespace classification_test {

const std::vector<ClassifiedPicture> kPictures{
    {0, {0, 1, 2}},          // right
    {0, {1, 0, 2}},          // second
    {1, {1}},                // right
    {2, {0, 1, 3, 4, 5, 2}}  // sixth
};

TEST(Accuracy, CountsTheFirstAndTheFirstFive) {
  const Scores scores = accuracy(kPictures, 6, {});
  EXPECT_DOUBLE_EQ(scores[0].value, 2.0 / 4);
  EXPECT_DOUBLE_EQ(scores[1].value, 3.0 / 4);
  EXPECT_DOUBLE_EQ(scores[2].value, (0.5 + 1 + 0) / 3);  // only classes that occur
}

TEST(Accuracy, OfPicturesThatCountSeveralTimes) {
  const std::vector<uint32_t> times{3, 0, 0, 1};
  EXPECT_DOUBLE_EQ(accuracy(kPictures, 6, times)[0].value, 0.75);
}

TEST(Accuracy, OfNoPicturesIsUndefined) {
  EXPECT_TRUE(std::isnan(accuracy({}, 3, {})[0].value));
}

TEST(Accuracy, PicturesWithoutResultsAreWrong) {
  const std::vector<ClassifiedPicture> pictures{{0, {}}, {0, {kNoClass}}};
  EXPECT_DOUBLE_EQ(accuracy(pictures, 1, {})[0].value, 0);
}

TEST(ConfusionMatrix, HasRowsOfTheTruthAndAColumnForOtherLabels) {
  std::vector<ClassifiedPicture> pictures{{0, {0}}, {0, {1}}, {1, {1}}, {1, {kNoClass}}, {1, {}}};
  EXPECT_EQ(confusion_matrix(pictures, 2),
            (std::vector<std::vector<uint64_t>>{{1, 1, 0}, {0, 1, 2}}));
}

}  // namespace classification_test
}  // namespace weir::evaluate
