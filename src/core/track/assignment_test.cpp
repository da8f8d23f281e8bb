// best_assignment against every permutation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace weir::track {
namespace assignment_test {

Matrix matrix(const std::vector<std::vector<double>>& rows) {
  Matrix out(rows.size(), rows.empty() ? 0 : rows[0].size());
  for (size_t r = 0; r < rows.size(); ++r)
    for (size_t c = 0; c < rows[r].size(); ++c) out.at(r, c) = rows[r][c];
  return out;
}

double sum_of(const Matrix& values, const std::vector<std::optional<size_t>>& columns) {
  double sum = 0;
  for (size_t r = 0; r < columns.size(); ++r)
    if (columns[r]) sum += values.at(r, *columns[r]);
  return sum;
}

// The largest sum of all ways to pair the smaller side with the larger one.
double best_sum(const Matrix& values) {
  const bool is_wide = values.rows() <= values.columns();
  const size_t small = std::min(values.rows(), values.columns());
  std::vector<size_t> order(std::max(values.rows(), values.columns()));
  std::iota(order.begin(), order.end(), size_t{0});
  double best = -1e300;
  do {
    double sum = 0;
    for (size_t i = 0; i < small; ++i)
      sum += is_wide ? values.at(i, order[i]) : values.at(order[i], i);
    best = std::max(best, sum);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

TEST(Assignment, TheBestSumIsNotTheBestPairFirst) {
  // 9 + 1 is less than 8 + 7.
  EXPECT_EQ(best_assignment(matrix({{9, 8}, {7, 1}})), (std::vector<std::optional<size_t>>{1, 0}));
}

TEST(Assignment, RowsWithoutAColumnHaveNone) {
  EXPECT_EQ(best_assignment(matrix({{1}, {3}, {2}})),
            (std::vector<std::optional<size_t>>{std::nullopt, 0, std::nullopt}));
}

TEST(Assignment, EmptySidesHaveNoPairs) {
  EXPECT_TRUE(best_assignment(Matrix(0, 3)).empty());
  EXPECT_EQ(best_assignment(Matrix(2, 0)), (std::vector<std::optional<size_t>>(2)));
}

TEST(Assignment, IsAsGoodAsTheBestPermutation) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(-1, 1);
  for (size_t rows = 1; rows <= 5; ++rows)
    for (size_t columns = 1; columns <= 5; ++columns)
      for (int i = 0; i < 20; ++i) {
        Matrix values(rows, columns);
        for (size_t r = 0; r < rows; ++r)
          for (size_t c = 0; c < columns; ++c) values.at(r, c) = value(random);
        const auto pairs = best_assignment(values);
        std::vector<size_t> used;
        for (const auto& column : pairs)
          if (column) used.push_back(*column);
        std::sort(used.begin(), used.end());
        EXPECT_EQ(used.size(), std::min(rows, columns));
        EXPECT_EQ(std::adjacent_find(used.begin(), used.end()), used.end());
        EXPECT_NEAR(sum_of(values, pairs), best_sum(values), 1e-12);
      }
}

}  // namespace assignment_test
}  // namespace weir::track
