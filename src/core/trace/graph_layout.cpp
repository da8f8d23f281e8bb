// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/graph_layout.hpp"

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

std::vector<size_t> find_columns(size_t boxes, const std::vector<Arrow>& forward) {
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

// An arrow has a point in each column it crosses, which takes a place like a box.
struct Points {
  std::vector<Place> places;                  // of the boxes, then of the points
  std::vector<std::vector<size_t>> before;    // of each place, those with an arrow to it
  std::vector<std::vector<size_t>> of_arrow;  // from its start to its end
};

Points place_points(size_t boxes, const std::vector<Arrow>& forward) {
  Points out{std::vector<Place>(boxes), std::vector<std::vector<size_t>>(boxes),
             std::vector<std::vector<size_t>>(forward.size())};
  const auto columns = find_columns(boxes, forward);
  for (size_t i = 0; i < boxes; ++i) out.places[i].column = columns[i];
  for (size_t i = 0; i < forward.size(); ++i) {
    size_t last = forward[i].first;
    for (size_t c = columns[last] + 1; c < columns[forward[i].second]; ++c) {
      out.of_arrow[i].push_back(out.places.size());
      out.places.push_back({c, 0});
      out.before.push_back({last});
      last = out.of_arrow[i].back();
    }
    out.before[forward[i].second].push_back(last);
  }
  return out;
}

// Sets the rows of a column, whose predecessors have theirs. Returns the number of rows.
double set_rows(std::vector<size_t> members, Points* points) {
  auto& places = points->places;
  for (const size_t i : members) {
    const auto& before = points->before[i];
    for (const size_t b : before)
      places[i].row += places[b].row / static_cast<double>(before.size());
  }
  std::stable_sort(members.begin(), members.end(),
                   [&](size_t a, size_t b) { return places[a].row < places[b].row; });
  double free = 0;
  for (const size_t i : members) {
    places[i].row = std::max(places[i].row, free);
    free = places[i].row + 1;
  }
  return free;
}

}  // namespace

GraphLayout lay_out(size_t boxes, const std::vector<Arrow>& all) {
  std::vector<Arrow> arrows;
  for (const Arrow& arrow : all)
    if (arrow.first < boxes && arrow.second < boxes && arrow.first != arrow.second)
      arrows.push_back(arrow);
  const std::set<size_t> back = closing(boxes, arrows);
  std::vector<Arrow> forward = arrows;
  for (const size_t i : back) std::swap(forward[i].first, forward[i].second);
  Points points = place_points(boxes, forward);
  std::vector<std::vector<size_t>> in_column;
  for (size_t i = 0; i < points.places.size(); ++i) {
    const size_t column = points.places[i].column;
    if (in_column.size() <= column) in_column.resize(column + 1);
    in_column[column].push_back(i);
  }
  GraphLayout out;
  out.columns = in_column.size();
  for (auto& members : in_column)
    out.rows = std::max(out.rows, set_rows(std::move(members), &points));
  for (size_t i = 0; i < arrows.size(); ++i) {
    auto& through = points.of_arrow[i];
    if (back.contains(i)) std::reverse(through.begin(), through.end());
    Route route{arrows[i].first, arrows[i].second, {}};
    for (const size_t point : through) route.through.push_back(points.places[point]);
    out.routes.push_back(std::move(route));
  }
  points.places.resize(boxes);
  out.boxes = std::move(points.places);
  return out;
}

}  // namespace weir::trace
