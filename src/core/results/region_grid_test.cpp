// Tests of the grids of regions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/region_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace weir::results {
namespace region_grid_test {

using Masks = std::vector<uint8_t>;

Masks mask(const RegionGrid& grid, const Box& part, const Box& box, Size size) {
  Masks out;
  append_mask(grid, part, box, size, &out);
  return out;
}

TEST(RegionGrid, CropLeavesTheCellsInsideThePicture) {
  Box part{0, -24, 64, 72};  // a letterbox
  const auto out = crop({2, 4, {9, 9, 1, 2, 3, 4, 9, 9}}, {64, 48}, &part);
  EXPECT_EQ(out.width, 2u);
  EXPECT_EQ(out.height, 2u);
  EXPECT_EQ(out.numbers, (std::vector<uint16_t>{1, 2, 3, 4}));
  EXPECT_EQ(part, (Box{0, 0, 64, 48}));
}

TEST(RegionGrid, CropLeavesNothingOfAGridOutside) {
  for (const Box& outside :
       {Box{64, 0, 128, 48}, Box{-90, 0, -1, 48}, Box{std::nanf(""), 0, 64, 48}}) {
    Box part = outside;
    const auto out = crop({2, 1, {1, 2}}, {64, 48}, &part);
    EXPECT_EQ(out.numbers.size(), 0u);
  }
  Box part{0, 0, 64, 48};
  EXPECT_EQ(crop({}, {64, 48}, &part).numbers.size(), 0u);
}

// An object in the upper left quarter of a picture over which the grid lies.
TEST(RegionGrid, AMaskLiesOverItsBox) {
  const RegionGrid grid{4, 2, {0, 9, 7, 0, 0, 0, 0, 0}};
  EXPECT_EQ(mask(grid, {0, 0, 64, 48}, {0, 0, 32, 24}, {4, 2}),
            (Masks{0, 0, 255, 255, 0, 0, 255, 255}));
  EXPECT_EQ(mask(grid, {0, 0, 64, 48}, {-32, 0, 32, 24}, {4, 1}), (Masks{0, 0, 0, 255}));
}

TEST(RegionGrid, AMaskOutsideOfTheGridIsEmpty) {
  const RegionGrid grid{1, 1, {1}};
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(mask(grid, {0, 0, 8, 8}, {8, 8, 16, 16}, {2, 1}), (Masks{0, 0}));
  EXPECT_EQ(mask(grid, {0, 0, 0, 0}, {0, 0, 8, 8}, {1, 1}), (Masks{0}));
  EXPECT_EQ(mask(grid, {0, 0, 8, 8}, {0, 0, kInfinity, 8}, {1, 1}), (Masks{0}));
  EXPECT_EQ(mask({}, {0, 0, 8, 8}, {0, 0, 8, 8}, {1, 1}), (Masks{0}));
}

}  // namespace region_grid_test
}  // namespace weir::results
