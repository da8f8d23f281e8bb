// An optimal assignment for each group of competing pairs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/assignment.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "core/track/best_assignment.hpp"

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
    gains.at(place_of(rows, p.row), place_of(columns, p.column)) = -double{p.cost};
  const auto column_of = best_assignment(gains);
  for (size_t i = 0; i < n; ++i)
    if (column_of[i] && *column_of[i] < real)
      out->push_back(
          {rows[i], columns[*column_of[i]], static_cast<float>(-gains.at(i, *column_of[i]))});
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
