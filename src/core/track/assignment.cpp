// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/assignment.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

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

using Pairs = std::vector<PairCost>;

// Positions of the distinct values of `numbers`.
std::vector<uint32_t> distinct(std::vector<uint32_t> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}
size_t find_place(const std::vector<uint32_t>& sorted, uint32_t number) {
  return static_cast<size_t>(std::lower_bound(sorted.begin(), sorted.end(), number) -
                             sorted.begin());
}

void greedy(Pairs pairs, Pairs* out) {
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<uint32_t> rows, columns;
  for (const auto& p : pairs) rows.push_back(p.row), columns.push_back(p.column);
  rows = distinct(std::move(rows)), columns = distinct(std::move(columns));
  std::vector<bool> row_used(rows.size()), column_used(columns.size());
  for (const auto& p : pairs) {
    const size_t r = find_place(rows, p.row), c = find_place(columns, p.column);
    if (row_used[r] || column_used[c]) continue;
    row_used[r] = column_used[c] = true;
    out->push_back(p);
  }
}

void solve(const Pairs& pairs, Pairs* out) {
  std::vector<uint32_t> rows, columns;
  for (const auto& p : pairs) rows.push_back(p.row), columns.push_back(p.column);
  rows = distinct(std::move(rows)), columns = distinct(std::move(columns));
  if (std::min(rows.size(), columns.size()) > kOptimalLimit) return greedy(pairs, out);
  // Row i has a column of its own after the true ones, at cost 1, which leaves it without a pair.
  constexpr double kForbidden = 1e6;
  const size_t n = rows.size(), real = columns.size();
  Matrix gains(n, real + n);
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < real + n; ++j) gains.at(i, j) = j == real + i ? -1 : -kForbidden;
  for (const auto& p : pairs)
    gains.at(find_place(rows, p.row), find_place(columns, p.column)) = -double{p.cost};
  const auto assigned_columns = best_assignment(gains);
  for (size_t i = 0; i < n; ++i)
    if (assigned_columns[i] && *assigned_columns[i] < real)
      out->push_back({rows[i], columns[*assigned_columns[i]],
                      static_cast<float>(-gains.at(i, *assigned_columns[i]))});
}

}  // namespace

std::vector<std::optional<size_t>> best_assignment(const Matrix& values) {
  std::vector<std::optional<size_t>> out(values.rows());
  if (values.rows() == 0 || values.columns() == 0) return out;
  const bool is_transposed = values.rows() > values.columns();
  const auto assigned_rows = ShortestPaths(values, is_transposed).solve();
  for (size_t c = 0; c < assigned_rows.size(); ++c) {
    if (assigned_rows[c] == kNone) continue;
    if (is_transposed)
      out[c] = assigned_rows[c];
    else
      out[assigned_rows[c]] = c;
  }
  return out;
}

std::vector<PairCost> assign(std::span<const PairCost> candidates) {
  uint32_t n_rows = 0, n_columns = 0;
  for (const auto& c : candidates)
    n_rows = std::max(n_rows, c.row + 1), n_columns = std::max(n_columns, c.column + 1);
  std::vector<uint32_t> leader(size_t{n_rows} + n_columns);  // union-find; rows, then columns
  std::iota(leader.begin(), leader.end(), 0u);
  const auto find = [&](uint32_t i) {
    while (leader[i] != i) i = leader[i] = leader[leader[i]];
    return i;
  };
  for (const auto& c : candidates) leader[find(c.row)] = find(n_rows + c.column);
  std::map<uint32_t, Pairs> groups;
  for (const auto& c : candidates) groups[find(c.row)].push_back(c);
  Pairs out;
  for (const auto& [key, pairs] : groups) {
    if (pairs.size() == 1)
      out.push_back(pairs.front());
    else
      solve(pairs, &out);
  }
  return out;
}

}  // namespace weir::track
