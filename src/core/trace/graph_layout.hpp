// GraphLayout: places the boxes of a graph in columns from left to right and routes its arrows.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace weir::trace {

// Columns and rows start at 0. A box is less than 1 high, so boxes of one column do not overlap.
struct Place {
  size_t column = 0;
  double row = 0;
};

struct Route {
  size_t from = 0, to = 0;     // boxes
  std::vector<Place> through;  // free places in the columns in between, in the arrow's direction
};

struct GraphLayout {
  std::vector<Place> boxes;
  std::vector<Route> routes;  // in the order of the arrows
  size_t columns = 0;
  double rows = 0;  // the smallest number that holds all boxes
};

// Arrows lead to later columns, except those that close a cycle, which lead back. Ignores arrows
// from or to missing boxes and from a box to itself.
GraphLayout lay_out(size_t boxes, const std::vector<std::pair<size_t, size_t>>& arrows);

}  // namespace weir::trace
