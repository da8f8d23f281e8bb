// Tests of the search for cells with high scores, against a plain search.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/dense_scores.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace weir::detection {
namespace dense_scores_test {

using Found = std::vector<ScoredCell>;

Found find(const std::vector<float>& numbers, const DenseScores& scores, float threshold) {
  Found found;
  find_scored_cells(numbers, scores, threshold, &found);
  return found;
}

Found find_plainly(const std::vector<float>& numbers, const DenseScores& scores, float threshold) {
  Found found;
  for (size_t cell = 0; cell < scores.cells; ++cell) {
    float best = -INFINITY;
    int32_t index = 0;
    for (size_t c = 0; c < scores.classes; ++c) {
      const float score = numbers[scores.at(cell, scores.first_class + c)];
      if (score > best) best = score, index = static_cast<int32_t>(c);
    }
    if (scores.has_objectness) best *= numbers[scores.at(cell, scores.first_class - 1)];
    if (best >= threshold) found.push_back({static_cast<uint32_t>(cell), index, best});
  }
  return found;
}

TEST(DenseScores, AreThoseOfAPlainSearchInBothOrders) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> step(0, 20);  // equal scores are common
  for (const size_t cells : {1u, 7u, 511u, 512u, 513u, 2000u})
    for (const size_t classes : {1u, 3u, 4u, 9u, 80u})
      for (const bool has_objectness : {false, true})
        for (const bool are_inner : {false, true}) {
          const DenseScores scores{.cells = cells,
                                   .values = 5 + classes + 2,
                                   .cells_are_inner = are_inner,
                                   .first_class = 5,
                                   .classes = classes,
                                   .has_objectness = has_objectness};
          std::vector<float> numbers(cells * scores.values);
          for (float& number : numbers) number = static_cast<float>(step(random)) / 20;
          for (const float threshold : {0.3f, 0.9f, 1.0f})
            EXPECT_EQ(find(numbers, scores, threshold), find_plainly(numbers, scores, threshold));
        }
}

TEST(DenseScores, LeaveOutWhatIsNotAScore) {
  for (const bool are_inner : {false, true}) {
    const DenseScores scores{
        .cells = 1, .values = 3, .cells_are_inner = are_inner, .first_class = 1, .classes = 2};
    EXPECT_EQ(find({9, NAN, 0.5f}, scores, 0.1f), (Found{{0, 1, 0.5f}}));
    EXPECT_EQ(find({9, NAN, NAN}, scores, 0), Found{});
    EXPECT_EQ(find({9, INFINITY, 0.5f}, scores, 0.1f), Found{});
    EXPECT_EQ(find({9, 0, 0}, scores, 0), Found{});
    EXPECT_EQ(find({9, -1, -2}, scores, 0), Found{});
    DenseScores product = scores;
    product.has_objectness = true;
    EXPECT_EQ(find({NAN, 1, 1}, product, 0), Found{});
    EXPECT_EQ(find({0.5f, 1, 0.5f}, product, 0.5f), (Found{{0, 0, 0.5f}}));
    EXPECT_EQ(find({0, 1, 1}, product, 0), Found{});
  }
  EXPECT_EQ(find({}, {.cells = 0, .values = 6, .first_class = 4, .classes = 2}, 0), Found{});
}

}  // namespace dense_scores_test
}  // namespace weir::detection
