// Chooses columns by the longest path from a start, and rows by the mean of the predecessors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/layout.hpp"

#include <algorithm>
#include <set>

namespace weir::trace {
namespace {

using Arrow = std::pair<size_t, size_t>;

// The arrows that would close a cycle, found by depth-first search from each box.
std::set<size_t> closing(size_t boxes, const std::vector<Arrow>& arrows) {
  enum class State { New, Open, Done };
  std::vector<std::vector<size_t>> out(boxes);
  for (size_t i = 0; i < arrows.size(); ++i) out[arrows[i].first].push_back(i);
  std::vector<State> states(boxes, State::New);
  std::set<size_t> found;
  for (size_t start = 0; start < boxes; ++start) {
    std::vector<std::pair<size_t, size_t>> stack;  // a box and the index of its next arrow
    if (states[start] == State::New) stack.emplace_back(start, 0);
    while (!stack.empty()) {
      auto& [box, next] = stack.back();
      states[box] = State::Open;
      if (next == out[box].size()) {
        states[box] = State::Done;
        stack.pop_back();
        continue;
      }
      const size_t arrow = out[box][next++], to = arrows[arrow].second;
      if (states[to] == State::Open) found.insert(arrow);
      if (states[to] == State::New) stack.emplace_back(to, 0);
    }
  }
  return found;
}

std::vector<size_t> columns_of(size_t boxes, const std::vector<Arrow>& forward) {
  std::vector<size_t> columns(boxes, 0);
  bool changed = true;
  while (changed) {  // terminates: there are no cycles
    changed = false;
    for (const auto& [from, to] : forward)
      if (columns[to] < columns[from] + 1) {
        columns[to] = columns[from] + 1;
        changed = true;
      }
  }
  return columns;
}

}  // namespace

Layout lay_out(size_t boxes, const std::vector<Arrow>& all) {
  std::vector<Arrow> arrows;
  for (const Arrow& arrow : all)
    if (arrow.first < boxes && arrow.second < boxes && arrow.first != arrow.second)
      arrows.push_back(arrow);
  const std::set<size_t> back = closing(boxes, arrows);
  std::vector<Arrow> forward = arrows;
  for (const size_t i : back) std::swap(forward[i].first, forward[i].second);
  // An arrow has a point in each column it crosses, which takes a place like a box.
  std::vector<Place> places(boxes);
  std::vector<std::vector<size_t>> before(boxes), points(arrows.size());
  const auto columns = columns_of(boxes, forward);
  for (size_t i = 0; i < boxes; ++i) places[i].column = columns[i];
  for (size_t i = 0; i < arrows.size(); ++i) {
    size_t last = forward[i].first;
    for (size_t c = columns[last] + 1; c < columns[forward[i].second]; ++c) {
      points[i].push_back(places.size());
      places.push_back({c, 0});
      before.push_back({last});
      last = points[i].back();
    }
    before[forward[i].second].push_back(last);
  }
  Layout out;
  std::vector<std::vector<size_t>> in_column;
  for (size_t i = 0; i < places.size(); ++i) {
    if (in_column.size() <= places[i].column) in_column.resize(places[i].column + 1);
    in_column[places[i].column].push_back(i);
  }
  for (auto& members : in_column) {
    for (const size_t i : members) {
      for (const size_t b : before[i])
        places[i].row += places[b].row / static_cast<double>(before[i].size());
    }
    std::stable_sort(members.begin(), members.end(),
                     [&](size_t a, size_t b) { return places[a].row < places[b].row; });
    double free = 0;
    for (const size_t i : members) {
      places[i].row = std::max(places[i].row, free);
      free = places[i].row + 1;
    }
    out.rows = std::max(out.rows, free);
  }
  out.columns = in_column.size();
  for (size_t i = 0; i < arrows.size(); ++i) {
    if (back.contains(i)) std::reverse(points[i].begin(), points[i].end());
    Route route{arrows[i].first, arrows[i].second, {}};
    for (const size_t point : points[i]) route.through.push_back(places[point]);
    out.routes.push_back(std::move(route));
  }
  places.resize(boxes);
  out.boxes = std::move(places);
  return out;
}

}  // namespace weir::trace
