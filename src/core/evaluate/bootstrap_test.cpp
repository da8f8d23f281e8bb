// Intervals against the known spread of a mean.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/bootstrap.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace weir::evaluate {
namespace bootstrap_test {

// The mean of `values`, each as often as a draw says.
Measure mean_of(const std::vector<double>& values) {
  return [&values](Times times) {
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i) sum += times[i] * values[i];
    return std::vector<double>{sum / static_cast<double>(values.size())};
  };
}

TEST(Bootstrap, IntervalOfAPartIsThatOfTheBinomialDistribution) {
  // 120 of 400 pictures right: 0.3 +- 1.96 sqrt(0.3 0.7 / 400).
  std::vector<double> values(400, 0);
  std::fill(values.begin(), values.begin() + 120, 1);
  const auto interval = bootstrap(values.size(), 4000, 1, mean_of(values)).at(0);
  const double spread = 1.96 * std::sqrt(0.3 * 0.7 / 400);
  EXPECT_NEAR(interval.low, 0.3 - spread, 0.004);
  EXPECT_NEAR(interval.high, 0.3 + spread, 0.004);
}

TEST(Bootstrap, EachDrawHasAsManyPicturesAsThereAre) {
  bootstrap(7, 50, 3, [](Times times) {
    EXPECT_EQ(std::accumulate(times.begin(), times.end(), 0U), 7U);
    return std::vector<double>{0};
  });
}

TEST(Bootstrap, TheSameSeedGivesTheSameInterval) {
  std::vector<double> values(50);
  std::iota(values.begin(), values.end(), 0.0);
  const auto first = bootstrap(50, 100, 5, mean_of(values)).at(0);
  const auto again = bootstrap(50, 100, 5, mean_of(values)).at(0);
  const auto other = bootstrap(50, 100, 6, mean_of(values)).at(0);
  EXPECT_EQ(first.low, again.low);
  EXPECT_EQ(first.high, again.high);
  EXPECT_NE(first.low, other.low);
}

TEST(Bootstrap, ADifferenceThatIsEqualInEachPictureHasNoSpread) {
  std::vector<double> values(30);
  std::iota(values.begin(), values.end(), 0.0);
  const auto intervals = bootstrap(30, 200, 1, [&](Times times) {
    const double mean = mean_of(values)(times)[0];
    return std::vector<double>{mean, (mean + 2) - mean};
  });
  EXPECT_LT(intervals[0].low, intervals[0].high);
  EXPECT_NEAR(intervals[1].low, 2, 1e-12);
  EXPECT_NEAR(intervals[1].high, 2, 1e-12);
}

TEST(Bootstrap, DrawsWithoutTheScoreAreLeftOut) {
  const auto none = bootstrap(3, 20, 1, [](Times) { return std::vector<double>{kUndefined}; });
  EXPECT_TRUE(std::isnan(none[0].low));
  const auto some = bootstrap(
      3, 50, 1, [](Times times) { return std::vector<double>{times[0] > 0 ? 1 : kUndefined}; });
  EXPECT_DOUBLE_EQ(some[0].low, 1);
}

}  // namespace bootstrap_test
}  // namespace weir::evaluate
