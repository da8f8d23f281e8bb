// Tests of segmentation outputs, with expected values in closed form and from NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/segmentation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace weir::detection {
namespace segmentation_test {

using Classes = std::vector<uint16_t>;

Classes best(const std::vector<float>& scores, size_t classes, float threshold = 0.5f) {
  Classes out(scores.size() / classes, 99);
  classes_from_scores(scores, classes, threshold, out);
  return out;
}

TEST(ClassesFromScores, TakesTheGreatestScoreOfEachPixel) {
  EXPECT_EQ(best({0.6f, 0.7f, 0.9f, /**/ 0.9f, 0.7f, 0.6f, /**/ 0, 8, 7}, 3), (Classes{2, 0, 1}));
}

TEST(ClassesFromScores, GivesClass0ToAPixelWithoutAScoreAboveTheThreshold) {
  const float above = std::nextafter(0.5f, 1.f);
  EXPECT_EQ(best({0.1f, 0.2f, 0.49f, /**/ 0, 0.5f, 0.5f, /**/ 0, 0, above, /**/ -9, -8, -7}, 3),
            (Classes{0, 0, 2, 0}));
}

TEST(ClassesFromScores, TakesTheFirstOfEqualScores) {
  EXPECT_EQ(best({0, 3, 3, /**/ 3, 0, 3}, 3), (Classes{1, 0}));
}

TEST(ClassesFromScores, NeverChoosesNotANumber) {
  EXPECT_EQ(best({NAN, 1, 2, /**/ 1, 2, NAN, /**/ 0, NAN, 1, /**/ NAN, NAN, NAN}, 3),
            (Classes{2, 1, 2, 0}));
}

TEST(ClassesFromScores, ComparesInfiniteScores) {
  EXPECT_EQ(best({-INFINITY, 1, INFINITY, /**/ -INFINITY, -INFINITY, -INFINITY}, 3),
            (Classes{2, 0}));
}

// numpy: s = ((np.arange(8 * 21) * 7919 % 1009) / 1009).astype('f4').reshape(8, 21)
//        np.where(s.max(1) > .5, s.argmax(1), 0)
TEST(ClassesFromScores, AgreesWithNumPy) {
  std::vector<float> scores(8 * 21);
  for (size_t i = 0; i < scores.size(); ++i)
    scores[i] = static_cast<float>(static_cast<double>(i * 7919 % 1009) / 1009);
  EXPECT_EQ(best(scores, 21), (Classes{20, 12, 11, 3, 15, 14, 6, 18}));
}

TEST(ClassesFromNumbers, RoundsTowardZero) {
  const std::vector<float> numbers{0, 1, 1.75f, 20, 20.9f, -0.5f};
  Classes out(numbers.size(), 99);
  EXPECT_EQ(classes_from_numbers(numbers, 21, out), std::nullopt);
  EXPECT_EQ(out, (Classes{0, 1, 1, 20, 20, 0}));
}

TEST(ClassesFromNumbers, TakesAsManyClassesAsItsNumbersHold) {
  const std::vector<float> numbers{65535};
  Classes out(1);
  EXPECT_EQ(classes_from_numbers(numbers, 65536, out), std::nullopt);
  EXPECT_EQ(out[0], 65535);
}

TEST(ClassesFromNumbers, NamesTheFirstValueThatIsNoClass) {
  for (const float odd : {21.f, -1.f, -7.f, 1e30f, NAN, INFINITY, -INFINITY}) {
    std::vector<float> numbers(40, 20);
    numbers[17] = odd;
    numbers[30] = odd;
    Classes out(numbers.size());
    EXPECT_EQ(classes_from_numbers(numbers, 21, out), 17u) << odd;
  }
}

TEST(MaxDepth, IsTheGreatestOfAllValues) {
  for (const size_t count : {1u, 15u, 16u, 17u, 100u})
    for (size_t place = 0; place < count; ++place) {
      std::vector<float> depths(count, 0.25f);
      depths[place] = 7.5f;
      const auto found = max_depth(depths);
      EXPECT_EQ(found.value, 7.5f) << place << " of " << count;
      EXPECT_FALSE(found.not_finite);
    }
}

TEST(MaxDepth, Is0WithoutAPositiveValue) {
  EXPECT_EQ(max_depth({}).value, 0);
  EXPECT_EQ(max_depth(std::vector<float>{0, 0}).value, 0);
  EXPECT_EQ(max_depth(std::vector<float>{-1, -2}).value, 0);
}

TEST(MaxDepth, NamesTheFirstValueThatIsNotFinite) {
  for (const float odd : {NAN, INFINITY, -INFINITY})
    for (const size_t place : {0u, 5u, 16u, 36u}) {
      std::vector<float> depths(40, 1);
      depths[place] = odd;
      depths[39] = odd;
      EXPECT_EQ(max_depth(depths).not_finite, place) << odd;
    }
}

TEST(GraysFromDepths, RoundsDown) {
  const std::vector<float> depths{0, 1, 2, 3, 4, 0.01f, -1};
  std::vector<uint8_t> out(depths.size(), 7);
  grays_from_depths(depths, 4, out);  // 255 / 4 = 63.75
  EXPECT_EQ(out, (std::vector<uint8_t>{0, 63, 127, 191, 255, 0, 0}));
}

TEST(GraysFromDepths, GivesTheGreatestDepth255) {
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    const float depth = std::ldexp(1 + std::generate_canonical<float, 24>(random), i % 250 - 125);
    uint8_t out = 0;
    grays_from_depths({&depth, 1}, depth, {&out, 1});
    EXPECT_EQ(out, 255) << depth;
  }
}

// numpy: d = (np.arange(24) * 37 % 101 / 8).astype('f4'); (d / d.max() *
// np.float32(255)).astype('u1')
TEST(GraysFromDepths, AgreesWithNumPy) {
  std::vector<float> depths(24);
  for (size_t i = 0; i < depths.size(); ++i) depths[i] = static_cast<float>(i * 37 % 101) / 8;
  std::vector<uint8_t> out(depths.size());
  grays_from_depths(depths, max_depth(depths).value, out);
  EXPECT_EQ(out, (std::vector<uint8_t>{0,   97, 194, 26,  123, 220, 52,  149, 247, 78, 176, 7, 105,
                                       202, 34, 131, 228, 60,  157, 255, 86,  184, 15, 113}));
}

}  // namespace segmentation_test
}  // namespace weir::detection
