// Adds one row after the other by the shortest augmenting path (Jonker and Volgenant, 1987).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/best_assignment.hpp"

#include <limits>

namespace weir::track {
namespace {

constexpr size_t kNone = SIZE_MAX;

// Minimises the sum of costs; no more rows than columns. Index 0 of columns is a start node, so
// columns count from 1.
class ShortestPaths {
 public:
  ShortestPaths(const Matrix& values, bool is_transposed)
      : values_(values),
        is_transposed_(is_transposed),
        rows_(is_transposed ? values.columns() : values.rows()),
        columns_(is_transposed ? values.rows() : values.columns()),
        row_price_(rows_),
        column_price_(columns_ + 1),
        row_of_(columns_ + 1, kNone) {}

  // The row of each column, kNone for columns without one.
  std::vector<size_t> solve() {
    for (size_t row = 0; row < rows_; ++row) add(row);
    return {row_of_.begin() + 1, row_of_.end()};
  }

 private:
  double cost(size_t row, size_t column) const noexcept {
    return -(is_transposed_ ? values_.at(column - 1, row) : values_.at(row, column - 1));
  }

  void add(size_t new_row) {
    std::vector<double> distance(columns_ + 1, std::numeric_limits<double>::infinity());
    std::vector<size_t> before(columns_ + 1, 0);
    std::vector<bool> is_done(columns_ + 1, false);
    row_of_[0] = new_row;
    size_t column = 0;
    while (row_of_[column] != kNone) {
      is_done[column] = true;
      const size_t row = row_of_[column];
      double least = std::numeric_limits<double>::infinity();
      size_t next = 0;
      for (size_t c = 1; c <= columns_; ++c) {
        if (is_done[c]) continue;
        const double length = cost(row, c) - row_price_[row] - column_price_[c];
        if (length < distance[c]) {
          distance[c] = length;
          before[c] = column;
        }
        if (distance[c] < least) {
          least = distance[c];
          next = c;
        }
      }
      for (size_t c = 0; c <= columns_; ++c) {
        if (!is_done[c]) {
          distance[c] -= least;
          continue;
        }
        row_price_[row_of_[c]] += least;
        column_price_[c] -= least;
      }
      column = next;
    }
    for (; column != 0; column = before[column]) row_of_[column] = row_of_[before[column]];
  }

  const Matrix& values_;
  const bool is_transposed_;
  const size_t rows_, columns_;
  std::vector<double> row_price_, column_price_;
  std::vector<size_t> row_of_;
};

}  // namespace

std::vector<std::optional<size_t>> best_assignment(const Matrix& values) {
  std::vector<std::optional<size_t>> out(values.rows());
  if (values.rows() == 0 || values.columns() == 0) return out;
  const bool is_transposed = values.rows() > values.columns();
  const auto row_of = ShortestPaths(values, is_transposed).solve();
  for (size_t c = 0; c < row_of.size(); ++c) {
    if (row_of[c] == kNone) continue;
    if (is_transposed)
      out[c] = row_of[c];
    else
      out[row_of[c]] = c;
  }
  return out;
}

}  // namespace weir::track
