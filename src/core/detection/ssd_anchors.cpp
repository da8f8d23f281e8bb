// Makes the anchors of SSD MobileNet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/ssd_anchors.hpp"

#include <cmath>

namespace weir::detection {
namespace {

constexpr uint32_t kGrids = 6, kFirstStride = 16;
constexpr double kLeastScale = 0.2, kGreatestScale = 0.95, kScaleOfFirst = 0.1;

struct AnchorSize {
  double height, width;
};

// Of the ratio width / height, with the area of a square of this scale.
AnchorSize size_of(double scale, double ratio) {
  return {scale / std::sqrt(ratio), scale * std::sqrt(ratio)};
}

std::vector<AnchorSize> sizes_of(uint32_t grid) {
  const auto scale = [](uint32_t i) {
    return kLeastScale + (kGreatestScale - kLeastScale) * i / (kGrids - 1);
  };
  if (grid == 0) return {size_of(kScaleOfFirst, 1), size_of(scale(0), 2), size_of(scale(0), 0.5)};
  std::vector<AnchorSize> out;
  for (const double ratio : {1.0, 2.0, 0.5, 3.0, 1.0 / 3})
    out.push_back(size_of(scale(grid), ratio));
  const double next = grid + 1 < kGrids ? scale(grid + 1) : 1.0;
  out.push_back(size_of(std::sqrt(scale(grid) * next), 1));
  return out;
}

// Calls `visit` with the number, the columns and the rows of each grid.
template <class Visit>
void for_each_grid(PictureSize input, Visit visit) {
  uint32_t columns = input.width / kFirstStride + (input.width % kFirstStride > 0 ? 1 : 0);
  uint32_t rows = input.height / kFirstStride + (input.height % kFirstStride > 0 ? 1 : 0);
  for (uint32_t grid = 0; grid < kGrids; ++grid) {
    visit(grid, columns, rows);
    columns = (columns + 1) / 2, rows = (rows + 1) / 2;
  }
}

}  // namespace

size_t ssd_anchor_count(PictureSize input) noexcept {
  constexpr size_t kOfFirst = 3, kOfOthers = 6;
  size_t count = 0;
  for_each_grid(input, [&](uint32_t grid, uint32_t columns, uint32_t rows) {
    count += size_t{columns} * rows * (grid == 0 ? kOfFirst : kOfOthers);
  });
  return count;
}

BoxPriors make_ssd_anchors(PictureSize input) {
  BoxPriors out;
  for_each_grid(input, [&](uint32_t grid, uint32_t columns, uint32_t rows) {
    const auto sizes = sizes_of(grid);
    for (uint32_t y = 0; y < rows; ++y)
      for (uint32_t x = 0; x < columns; ++x)
        for (const AnchorSize& size : sizes) {
          out.y.push_back(static_cast<float>((y + 0.5) / rows));
          out.x.push_back(static_cast<float>((x + 0.5) / columns));
          out.height.push_back(static_cast<float>(size.height));
          out.width.push_back(static_cast<float>(size.width));
        }
  });
  return out;
}

}  // namespace weir::detection
