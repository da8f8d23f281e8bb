// Layout: places boxes of a graph in columns from left to right, and routes for its arrows.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace weir::trace {

// Columns and rows from 0 on; a box is less than 1 high, so those of one column do not overlap.
struct Place {
  size_t column = 0;
  double row = 0;
};

struct Route {
  size_t from = 0, to = 0;     // boxes
  std::vector<Place> through;  // free places in the columns between, in the order of the arrow
};

struct Layout {
  std::vector<Place> boxes;
  std::vector<Route> routes;  // as the arrows
  size_t columns = 0;
  double rows = 0;  // the least number that holds all
};

// An arrow leads to a later column, but for those that close a circle: they lead back. Arrows from
// or to boxes that are not there, and from a box to itself, are left out.
Layout lay_out(size_t boxes, const std::vector<std::pair<size_t, size_t>>& arrows);

}  // namespace weir::trace
