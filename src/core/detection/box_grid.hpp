// BoxGrid: finds the boxes near another one without looking at all of them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace weir::detection {

// The first and the last pixel that a box can touch.
struct Extent {
  int64_t left = 0, top = 0, right = 0, bottom = 0;
};

// Boxes are in each cell of the grid that they touch; boxes of many cells are in a list instead.
class BoxGrid {
 public:
  // The grid covers all of `extents`, within 32768 pixels of the origin. What is beyond belongs to
  // the cells at the edge, which keeps boxes that touch in a cell that both have.
  explicit BoxGrid(std::span<const Extent> extents) {
    int64_t right = -kFar, bottom = -kFar;
    for (const Extent& extent : extents) {
      left_ = std::min(left_, bounded(extent.left));
      top_ = std::min(top_, bounded(extent.top));
      right = std::max(right, bounded(extent.right));
      bottom = std::max(bottom, bounded(extent.bottom));
    }
    cell_width_ = std::max<int64_t>(1, (right - left_) / kCells + 1);
    cell_height_ = std::max<int64_t>(1, (bottom - top_) / kCells + 1);
  }

  void add(uint32_t box, const Extent& extent) {
    all_.push_back(box);
    const Cells cells = get_cells(extent);
    if (cells.count() > kFewCells) {
      large_.push_back(box);
      return;
    }
    for (int64_t row = cells.top; row <= cells.bottom; ++row)
      for (int64_t column = cells.left; column <= cells.right; ++column)
        cells_[static_cast<size_t>(row * kCells + column)].push_back(box);
  }

  // Whether `is_wanted` is true for a box that may touch `extent`; may ask more than once for one.
  template <class IsWanted>
  bool any_near(const Extent& extent, IsWanted&& is_wanted) const {
    const Cells cells = get_cells(extent);
    if (cells.count() > kFewCells) return std::any_of(all_.begin(), all_.end(), is_wanted);
    if (std::any_of(large_.begin(), large_.end(), is_wanted)) return true;
    for (int64_t row = cells.top; row <= cells.bottom; ++row)
      for (int64_t column = cells.left; column <= cells.right; ++column) {
        const auto& cell = cells_[static_cast<size_t>(row * kCells + column)];
        if (std::any_of(cell.begin(), cell.end(), is_wanted)) return true;
      }
    return false;
  }

 private:
  static constexpr int64_t kCells = 64, kFewCells = 16, kFar = 32768;
  struct Cells {
    int64_t left, top, right, bottom;
    int64_t count() const noexcept { return (right - left + 1) * (bottom - top + 1); }
  };
  static int64_t bounded(int64_t at) noexcept { return std::clamp(at, -kFar, kFar); }
  Cells get_cells(const Extent& extent) const noexcept {
    const auto cell = [](int64_t at, int64_t first, int64_t size) {
      return std::clamp<int64_t>((bounded(at) - first) / size, 0, kCells - 1);
    };
    return {cell(extent.left, left_, cell_width_), cell(extent.top, top_, cell_height_),
            cell(extent.right, left_, cell_width_), cell(extent.bottom, top_, cell_height_)};
  }

  int64_t left_ = kFar, top_ = kFar, cell_width_ = 1, cell_height_ = 1;
  std::array<std::vector<uint32_t>, static_cast<size_t>(kCells* kCells)> cells_;
  std::vector<uint32_t> large_, all_;
};

}  // namespace weir::detection
