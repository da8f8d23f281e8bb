// PlanTables: everything that a plan computes before the first frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <vector>

#include "core/preprocess/axis.hpp"
#include "core/preprocess/placement.hpp"
#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/row_memory.hpp"

namespace weir::preprocess {

// The tables that make target pixels from planes with the same sampling.
struct Grid {
  Component sampling;
  size_t first_byte = 0, bytes = 0;  // what is read of each row
  Axis rows, columns;
  size_t taps = 0;  // `index` and `weights` are in the form of tap_kernels.hpp
  RowMemory<int32_t> index;
  RowMemory<float> weights;
};

// A plane and the grid of the components that are read from it together.
struct PlaneGrid {
  uint8_t plane = 0;
  size_t grid = 0;
};

struct ComponentSource {
  size_t plane_grid = 0, offset = 0;  // offset: bytes from the start of a sample of the grid
};

struct PlanTables {
  explicit PlanTables(Preparation preparation);

  // Precondition: check_crop(). Keeps the tables' memory and everything that does not depend on the
  // crop.
  void set_crop(const Rect& crop);
  // The same for a region. Precondition: place() shows a part of it.
  void set_region(const Rect& picture, const Roi& region);

  Preparation preparation;
  Placement placement;
  std::vector<Grid> grids;
  std::vector<PlaneGrid> plane_grids;
  std::vector<ComponentSource> components;  // the samples that the target needs: 1 or 3
  ColorTransform colors;
  // Index into components, by sample of `colors`.
  std::array<size_t, 3> component_of_sample{0, 1, 2};
  std::vector<NumberRule> numbers;  // one for each channel of the target
  std::vector<std::byte> padding;   // NHWC: one row of pixels; NCHW: one row for each channel

 private:
  size_t find_grid(const Component& component, size_t known);
  void lay_colors();
  void lay_plane_grids();
};

}  // namespace weir::preprocess
