// Assigns detections to tracks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace weir::track {

// Assignment: pairs rows with columns of a matrix so that the sum of the values is as large as
// possible (the Hungarian method).

class Matrix {
 public:
  Matrix(size_t rows, size_t columns) : rows_(rows), columns_(columns), values_(rows * columns) {}
  size_t rows() const noexcept { return rows_; }
  size_t columns() const noexcept { return columns_; }
  double& at(size_t row, size_t column) noexcept { return values_[row * columns_ + column]; }
  double at(size_t row, size_t column) const noexcept { return values_[row * columns_ + column]; }

 private:
  size_t rows_, columns_;
  std::vector<double> values_;
};

// The column of each row; as many rows have one as there are columns, if there are fewer columns.
// Values may be 0: callers leave such pairs out. Takes time in proportion to the square of the
// smaller side and to the larger one.
std::vector<std::optional<size_t>> best_assignment(const Matrix& values);

// Pairs tracks with boxes so that the sum of the pairs' costs is least.

// A pair that may be formed; the lower the cost the better. Costs are finite and at most 1.
struct PairCost {
  uint32_t row = 0, column = 0;
  float cost = 0;
};

// Up to this many rows or columns that compete with each other, whichever is less, are paired
// optimally; more of them greedily, least cost first.
inline constexpr size_t kOptimalLimit = 256;

// Returns the chosen pairs; each row and each column is in at most one. As many pairs are formed as
// the least sum of costs allows, where leaving a row without a pair costs 1. Rows that compete for
// no column are solved apart; of those that do, the time grows with the smaller side times the
// pairs.
std::vector<PairCost> assign(std::span<const PairCost> candidates);

}  // namespace weir::track
