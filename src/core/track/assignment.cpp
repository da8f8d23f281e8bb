// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/assignment.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

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

// The same for few pairs of many: the work grows with the pairs, not with rows times columns. A row
// may stay without a column, at cost 1.
class SparsePaths {
 public:
  SparsePaths(size_t rows, size_t columns)
      : edges_(rows),
        row_price_(rows),
        column_price_(columns),
        column_of_(rows, kNone),
        row_of_(columns, kNone),
        distance_(columns, kInfinite),
        before_(columns),
        is_done_(columns) {}

  void allow(size_t row, size_t column, double cost) { edges_[row].push_back({column, cost}); }

  // The column of each row, kNone for rows without one.
  const std::vector<size_t>& solve() {
    for (size_t row = 0; row < edges_.size(); ++row) add(row);
    return column_of_;
  }

 private:
  static constexpr double kInfinite = std::numeric_limits<double>::infinity(), kUnpaired = 1;
  struct Edge {
    size_t column;
    double cost;
  };
  struct End {
    double distance = kInfinite;
    size_t row = kNone, column = kNone;  // no column: the row stays without one
  };
  using Reached = std::pair<double, size_t>;  // distance, column; the nearest is the top
  using Queue = std::priority_queue<Reached, std::vector<Reached>, std::greater<>>;

  // Shortens paths by way of `row`, which is `from` away.
  void extend(size_t row, double from, Queue* queue, End* end) {
    for (const Edge& edge : edges_[row]) {
      if (is_done_[edge.column]) continue;
      const double length = from + edge.cost - row_price_[row] - column_price_[edge.column];
      if (length >= distance_[edge.column]) continue;
      if (distance_[edge.column] == kInfinite) reached_.push_back(edge.column);
      distance_[edge.column] = length;
      before_[edge.column] = row;
      queue->push({length, edge.column});
    }
    const double length = from + kUnpaired - row_price_[row];
    if (length < end->distance) *end = {length, row, kNone};
  }

  End shortest_path(size_t new_row) {
    Queue queue;
    End end;
    extend(new_row, 0, &queue, &end);
    while (!queue.empty() && queue.top().first < end.distance) {
      const auto [distance, column] = queue.top();
      queue.pop();
      if (is_done_[column]) continue;
      if (row_of_[column] == kNone) return {distance, before_[column], column};
      is_done_[column] = true;
      extend(row_of_[column], distance, &queue, &end);
    }
    return end;
  }

  void add(size_t new_row) {
    row_price_[new_row] = kUnpaired;
    for (const Edge& edge : edges_[new_row])
      row_price_[new_row] = std::min(row_price_[new_row], edge.cost - column_price_[edge.column]);
    const End end = shortest_path(new_row);
    row_price_[new_row] += end.distance;
    for (const size_t column : reached_) {
      if (is_done_[column]) {
        row_price_[row_of_[column]] += end.distance - distance_[column];
        column_price_[column] -= end.distance - distance_[column];
      }
      distance_[column] = kInfinite;
      is_done_[column] = false;
    }
    reached_.clear();
    size_t column = end.column;
    for (size_t row = end.row;; row = before_[column]) {
      std::swap(column, column_of_[row]);
      if (column_of_[row] != kNone) row_of_[column_of_[row]] = row;
      if (row == new_row) return;
    }
  }

  std::vector<std::vector<Edge>> edges_;  // of each row
  std::vector<double> row_price_, column_price_;
  std::vector<size_t> column_of_, row_of_;
  // Of one path:
  std::vector<double> distance_;
  std::vector<size_t> before_;  // the row by which a column is reached
  std::vector<bool> is_done_;
  std::vector<size_t> reached_;
};

void solve(const Pairs& pairs, Pairs* out) {
  std::vector<uint32_t> rows, columns;
  for (const auto& p : pairs) rows.push_back(p.row), columns.push_back(p.column);
  rows = distinct(std::move(rows)), columns = distinct(std::move(columns));
  if (std::min(rows.size(), columns.size()) > kOptimalLimit) return greedy(pairs, out);
  const bool is_transposed = rows.size() > columns.size();
  SparsePaths paths(std::min(rows.size(), columns.size()), std::max(rows.size(), columns.size()));
  const auto place = [&](const PairCost& pair) {
    const size_t row = find_place(rows, pair.row), column = find_place(columns, pair.column);
    return is_transposed ? std::pair(column, row) : std::pair(row, column);
  };
  for (const auto& p : pairs) paths.allow(place(p).first, place(p).second, double{p.cost});
  const auto& assigned_columns = paths.solve();
  for (const auto& p : pairs)
    if (assigned_columns[place(p).first] == place(p).second) out->push_back(p);
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
