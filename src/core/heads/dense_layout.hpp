// DenseLayout: how the output of a detector with many cells lies in memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "core/heads/head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {

// Detectors cut the picture into grids of cells, of 8, 16 and 32 pixels for example, and give
// `values` numbers for each cell and anchor. Cells go row after row, the grid of the smallest cells
// first.
struct DenseLayout {
  size_t rows = 0, values = 0;      // rows: cells of all grids times anchors
  bool rows_are_inner = false;      // the rows are the innermost dimension
  size_t anchors = 1;               // of each cell
  std::vector<uint32_t> strides{};  // pixels of a cell, of each grid; empty = not known
  Size input{};                     // 0 x 0 = not known
};

// The layout of an output of two dimensions whose rows are the cells of `input`, with one anchor or
// three. Without an input size, the square picture that has as many cells, if there is one.
std::optional<DenseLayout> find_dense_layout(const Shape& shape, Size input);
// The same where the family is known: any output of two dimensions, whose larger one counts rows.
std::optional<DenseLayout> any_dense_layout(const Shape& shape, Size input);

// Where a cell is.
struct CellPlace {
  uint32_t column = 0, row = 0, stride = 0;
};
// The places of all cells of one anchor, in their order; empty if strides or input are not known.
std::vector<CellPlace> cell_places(const DenseLayout& layout, Size input);

}  // namespace weir::heads
