// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/dense_layout.hpp"
#include "core/tensor/geometry.hpp"

#include <cmath>
#include <initializer_list>

namespace weir::heads {
namespace {

using Strides = std::initializer_list<uint32_t>;

// Grids of models: the usual ones, small models, models for small objects and for large pictures.
constexpr Strides kStrides[] = {{8, 16, 32}, {16, 32}, {4, 8, 16, 32}, {8, 16, 32, 64}};

// The last cell of a row may be beyond the edge.
uint32_t cells_along(uint32_t side, uint32_t stride) {
  return side / stride + (side % stride > 0 ? 1 : 0);
}

size_t count_cells(Size input, std::span<const uint32_t> strides) {
  size_t cells = 0;
  for (const uint32_t stride : strides)
    cells += size_t{cells_along(input.width, stride)} * cells_along(input.height, stride);
  return cells;
}

// The square picture with this many cells.
Size square_with(size_t cells, Strides strides) {
  const uint32_t largest = strides.end()[-1];
  size_t cells_of_a_block = 0;  // of a square of the largest stride
  for (const uint32_t stride : strides)
    cells_of_a_block += size_t{largest / stride} * (largest / stride);
  if (cells % cells_of_a_block != 0) return {};
  const size_t area = cells / cells_of_a_block;  // in blocks
  const auto blocks = static_cast<size_t>(std::lround(std::sqrt(static_cast<double>(area))));
  if (blocks == 0 || blocks > 1024 || blocks * blocks * cells_of_a_block != cells) return {};
  const auto side = static_cast<uint32_t>(blocks * largest);
  return {side, side};
}

DenseLayout make_layout(const Shape& shape, size_t row_dimension) {
  return {.rows = shape[row_dimension],
          .values = shape[1 - row_dimension],
          .rows_are_inner = row_dimension == 0};
}

std::optional<DenseLayout> with_strides(const Shape& shape, size_t row_dimension, Size input) {
  DenseLayout layout = make_layout(shape, row_dimension);
  for (const Strides& strides : kStrides)
    for (const size_t anchors : {1u, 3u}) {
      if (layout.rows % anchors != 0) continue;
      const size_t cells = layout.rows / anchors;
      const Size size = input.width > 0 ? input : square_with(cells, strides);
      if (size.width == 0 || count_cells(size, {strides.begin(), strides.end()}) != cells) continue;
      layout.anchors = anchors;
      layout.strides = strides;
      layout.input = size;
      return layout;
    }
  return std::nullopt;
}

}  // namespace

std::optional<DenseLayout> find_dense_layout(const Shape& shape, Size input) {
  if (shape.min_rank() != 2) return std::nullopt;
  const size_t larger = shape[0] > shape[1] ? 0 : 1;
  for (const size_t dimension : {larger, 1 - larger})
    if (auto layout = with_strides(shape, dimension, input)) return layout;
  return std::nullopt;
}

std::optional<DenseLayout> any_dense_layout(const Shape& shape, Size input) {
  if (shape.min_rank() > 2) return std::nullopt;
  if (auto layout = find_dense_layout(shape, input)) return layout;
  if (shape.rank() < 2) return std::nullopt;
  DenseLayout layout = make_layout(shape, shape[0] > shape[1] ? 0 : 1);
  layout.input = input;
  return layout;
}

std::vector<CellPlace> cell_places(const DenseLayout& layout, Size input) {
  std::vector<CellPlace> out;
  if (input.width == 0) input = layout.input;
  if (count_cells(input, layout.strides) * layout.anchors != layout.rows) return out;
  for (const uint32_t stride : layout.strides)
    for (uint32_t row = 0; row < cells_along(input.height, stride); ++row)
      for (uint32_t column = 0; column < cells_along(input.width, stride); ++column)
        out.push_back({column, row, stride});
  return out;
}

}  // namespace weir::heads
