// IoU of small class maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/segmentation.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace weir::evaluate {
namespace segmentation_test {

using Map = std::vector<uint32_t>;
constexpr uint32_t kIgnored = 255;

TEST(ClassMapOverlap, OverlapIsThatOfPixels) {
  // Class 0: 2 both, 3 either; class 1: 1 both, 3 either; class 2: only found.
  const std::vector<std::vector<ClassPixels>> pictures{
      compare_class_maps(Map{0, 0, 1, 1, 0}, Map{0, 0, 1, 2, 1}, kIgnored)};
  const auto overlaps = overlap_of_classes(pictures, 4, {});
  EXPECT_DOUBLE_EQ(overlaps[0], 2.0 / 3);
  EXPECT_DOUBLE_EQ(overlaps[1], 1.0 / 3);
  EXPECT_DOUBLE_EQ(overlaps[2], 0);
  EXPECT_TRUE(std::isnan(overlaps[3]));
  const auto scores = segmentation_scores(pictures, 4, {});
  EXPECT_DOUBLE_EQ(scores[0].value, (2.0 / 3 + 1.0 / 3 + 0) / 3);
  EXPECT_DOUBLE_EQ(scores[1].value, 3.0 / 5);
}

TEST(ClassMapOverlap, IgnoredPixelsDoNotCount) {
  const std::vector<std::vector<ClassPixels>> pictures{
      compare_class_maps(Map{0, kIgnored, kIgnored}, Map{0, 1, 0}, kIgnored)};
  EXPECT_DOUBLE_EQ(segmentation_scores(pictures, 2, {})[0].value, 1);
}

TEST(ClassMapOverlap, PixelsWithoutClassAreMissed) {
  const std::vector<std::vector<ClassPixels>> pictures{
      compare_class_maps(Map{1, 1}, Map{1, kNoPixelClass}, kIgnored)};
  EXPECT_DOUBLE_EQ(overlap_of_classes(pictures, 2, {})[1], 0.5);
}

TEST(ClassMapOverlap, SeveralPicturesAreOneSetOfPixels) {
  const std::vector<std::vector<ClassPixels>> pictures{
      compare_class_maps(Map{1, 1, 1}, Map{1, 1, 1}, kIgnored),
      compare_class_maps(Map{1}, Map{0}, kIgnored)};
  EXPECT_DOUBLE_EQ(overlap_of_classes(pictures, 2, {})[1], 3.0 / 4);
  const std::vector<uint32_t> times{0, 1};
  EXPECT_DOUBLE_EQ(overlap_of_classes(pictures, 2, times)[1], 0);
}

TEST(ClassMapOverlap, WithoutPixelsIsUndefined) {
  EXPECT_TRUE(std::isnan(segmentation_scores({}, 2, {})[0].value));
}

}  // namespace segmentation_test
}  // namespace weir::evaluate
