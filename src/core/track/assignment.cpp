// The Hungarian algorithm by shortest augmenting paths, for each group of competing pairs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/assignment.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

namespace weir::track {
namespace {

using Pairs = std::vector<Candidate>;

// Positions of the distinct values of `numbers`.
std::vector<uint32_t> distinct(std::vector<uint32_t> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}
size_t place_of(const std::vector<uint32_t>& sorted, uint32_t number) {
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
    const size_t r = place_of(rows, p.row), c = place_of(columns, p.column);
    if (row_used[r] || column_used[c]) continue;
    row_used[r] = column_used[c] = true;
    out->push_back(p);
  }
}

// The Hungarian algorithm: potentials, and shortest paths that give one row after another a column.
// Rows and columns count from 1; column 0 stands for the row that is being placed.
class Hungarian {
 public:
  // `cost`: n rows of m columns.
  Hungarian(const std::vector<double>& cost, size_t n, size_t m)
      : cost_(cost), m_(m), u_(n + 1), v_(m + 1), least_(m + 1), row_of_(m + 1), before_(m + 1) {
    for (size_t row = 1; row <= n; ++row) place(row);
  }
  const std::vector<size_t>& row_of_columns() const noexcept { return row_of_; }

 private:
  void place(size_t row) {
    row_of_[0] = row;
    std::fill(least_.begin(), least_.end(), std::numeric_limits<double>::infinity());
    visited_.assign(m_ + 1, false);
    size_t column = 0;
    do {
      visited_[column] = true;
      const size_t next = nearest(column);
      shift(least_[next]);
      column = next;
    } while (row_of_[column] != 0);
    for (; column != 0; column = before_[column]) row_of_[column] = row_of_[before_[column]];
  }
  // The column that is nearest to those visited, after a step from the row of `column`.
  size_t nearest(size_t column) {
    const size_t from = row_of_[column];
    size_t next = 0;
    for (size_t j = 1; j <= m_; ++j) {
      if (visited_[j]) continue;
      const double reduced = cost_[(from - 1) * m_ + j - 1] - u_[from] - v_[j];
      if (reduced < least_[j]) least_[j] = reduced, before_[j] = column;
      if (next == 0 || least_[j] < least_[next]) next = j;
    }
    return next;
  }
  void shift(double step) {
    for (size_t j = 0; j <= m_; ++j)
      if (visited_[j])
        u_[row_of_[j]] += step, v_[j] -= step;
      else
        least_[j] -= step;
  }

  const std::vector<double>& cost_;
  size_t m_;
  std::vector<double> u_, v_, least_;
  std::vector<size_t> row_of_, before_;
  std::vector<bool> visited_;
};

void solve(const Pairs& pairs, Pairs* out) {
  std::vector<uint32_t> rows, columns;
  for (const auto& p : pairs) rows.push_back(p.row), columns.push_back(p.column);
  rows = distinct(std::move(rows)), columns = distinct(std::move(columns));
  if (std::min(rows.size(), columns.size()) > kOptimalLimit) return greedy(pairs, out);
  const size_t n = rows.size(), real = columns.size(), m = real + n;
  constexpr double kForbidden = 1e6;
  // Row i has a column of its own after the true ones, at cost 1, which leaves it without a pair.
  std::vector<double> cost(n * m, kForbidden);
  for (const auto& p : pairs)
    cost[place_of(rows, p.row) * m + place_of(columns, p.column)] = p.cost;
  for (size_t i = 0; i < n; ++i) cost[i * m + real + i] = 1;
  const Hungarian hungarian(cost, n, m);
  const auto& row_of = hungarian.row_of_columns();
  for (size_t j = 0; j < real; ++j) {
    if (row_of[j + 1] == 0) continue;
    const size_t i = row_of[j + 1] - 1;
    if (cost[i * m + j] < kForbidden)
      out->push_back({rows[i], columns[j], static_cast<float>(cost[i * m + j])});
  }
}

}  // namespace

std::vector<Candidate> assign(std::span<const Candidate> candidates) {
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
