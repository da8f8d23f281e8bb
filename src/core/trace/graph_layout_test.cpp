// Boxes do not overlap, and arrows lead to the right.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/graph_layout.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace weir::trace {
namespace graph_layout_test {

TEST(TraceLayout, AChainIsARow) {
  const GraphLayout layout = lay_out(3, {{2, 0}, {0, 1}});
  const std::vector<size_t> columns{1, 2, 0};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(layout.boxes[i].column, columns[i]);
    EXPECT_EQ(layout.boxes[i].row, 0);
  }
  EXPECT_EQ(layout.columns, 3u);
  EXPECT_EQ(layout.rows, 1);
}

TEST(TraceLayout, BranchesStandBelowEachOther) {
  const GraphLayout layout = lay_out(3, {{0, 1}, {0, 2}});
  EXPECT_EQ(layout.boxes[1].row, 0);
  EXPECT_EQ(layout.boxes[2].row, 1);
  EXPECT_EQ(layout.rows, 2);
}

TEST(TraceLayout, AnArrowPassesTheColumnsBetweenAtFreePlaces) {
  const GraphLayout layout = lay_out(3, {{0, 1}, {1, 2}, {0, 2}});
  ASSERT_EQ(layout.routes[2].through.size(), 1u);
  EXPECT_EQ(layout.routes[2].through[0].column, 1u);
  EXPECT_GE(std::abs(layout.routes[2].through[0].row - layout.boxes[1].row), 1);
  EXPECT_TRUE(layout.routes[0].through.empty());
}

TEST(TraceLayout, ACycleHasOneBackwardArrow) {
  const GraphLayout layout = lay_out(3, {{0, 1}, {1, 2}, {2, 0}});
  EXPECT_EQ(layout.boxes[2].column, 2u);
  EXPECT_EQ(layout.routes[2].from, 2u);
  EXPECT_EQ(layout.routes[2].through.size(), 1u);
}

TEST(TraceLayout, ArrowsWithoutABoxAreOmitted) {
  const GraphLayout layout = lay_out(1, {{0, 0}, {0, 7}, {7, 0}});
  EXPECT_TRUE(layout.routes.empty());
  EXPECT_EQ(lay_out(0, {}).columns, 0u);
}

TEST(TraceLayout, NothingOverlapsInAnyGraph) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    const size_t boxes = 1 + random() % 12;
    std::vector<std::pair<size_t, size_t>> arrows(random() % 24);
    for (auto& arrow : arrows) arrow = {random() % boxes, random() % boxes};
    const GraphLayout layout = lay_out(boxes, arrows);
    std::vector<Place> taken = layout.boxes;
    for (const Route& route : layout.routes)
      taken.insert(taken.end(), route.through.begin(), route.through.end());
    for (size_t a = 0; a < taken.size(); ++a) {
      EXPECT_LE(taken[a].row + 1, layout.rows + 1e-9);
      for (size_t b = 0; b < a; ++b)
        EXPECT_TRUE(taken[a].column != taken[b].column ||
                    std::abs(taken[a].row - taken[b].row) > 1 - 1e-9);
    }
  }
}

}  // namespace graph_layout_test
}  // namespace weir::trace
