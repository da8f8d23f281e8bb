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

  // The shortest known paths from the start node to the columns.
  struct Paths {
    explicit Paths(size_t n) : distance(n, std::numeric_limits<double>::infinity()), before(n) {}
    std::vector<double> distance;
    std::vector<size_t> before;
    std::vector<bool> is_done = std::vector<bool>(before.size());
  };

  // Shortens paths by way of `column`. Returns the nearest column that is not done.
  size_t extend(size_t column, Paths* paths) const {
    const size_t row = row_of_[column];
    size_t nearest = 0;  // its distance stays infinite
    for (size_t c = 1; c <= columns_; ++c) {
      if (paths->is_done[c]) continue;
      const double length = cost(row, c) - row_price_[row] - column_price_[c];
      if (length < paths->distance[c]) {
        paths->distance[c] = length;
        paths->before[c] = column;
      }
      if (paths->distance[c] < paths->distance[nearest]) nearest = c;
    }
    return nearest;
  }

  void raise_prices(double step, Paths* paths) {
    for (size_t c = 0; c <= columns_; ++c) {
      if (!paths->is_done[c]) {
        paths->distance[c] -= step;
        continue;
      }
      row_price_[row_of_[c]] += step;
      column_price_[c] -= step;
    }
  }

  void add(size_t new_row) {
    Paths paths(columns_ + 1);
    row_of_[0] = new_row;
    size_t column = 0;
    while (row_of_[column] != kNone) {
      paths.is_done[column] = true;
      column = extend(column, &paths);
      raise_prices(paths.distance[column], &paths);
    }
    for (; column != 0; column = paths.before[column])
      row_of_[column] = row_of_[paths.before[column]];
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
