// Reads the outputs of pose networks: heat maps, with or without offsets, as key points.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/detection/candidate.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::detection {

// The cells of a heat map. Its values are stored row after row, and those of all key points of a
// cell one after the other.
struct HeatGrid {
  size_t points = 0, width = 0, height = 0;
  size_t values() const noexcept { return points * width * height; }
};

// What the values of a heat map are.
enum class Heat {
  Probability,
  Logit  // the probability is the value's sigmoid 1 / (1 + exp(-value))
};

// The cell with the highest probability of a key point.
struct HeatPeak {
  uint32_t column = 0, row = 0;
  float probability = 0;
  bool operator==(const HeatPeak&) const = default;
};

// Finds the peak of each key point; the first of equal cells wins. Not-a-number never wins: a key
// point without a number above minus infinity has cell 0, 0 and probability 0. Precondition: `maps`
// has grid.values() and `peaks` has grid.points elements.
void find_peaks(std::span<const float> maps, const HeatGrid& grid, Heat heat,
                std::span<HeatPeak> peaks) noexcept;

struct PosePoint {
  float x = 0, y = 0;
  bool operator==(const PosePoint&) const = default;
};

// The position of key point `index` in pixels of the model's input: the first cells of the grid are
// at 0, the last ones at the width and the height of the input, and the cell's offset is added.
// `offsets` has twice as many values per cell as the heat map: all y, then all x. The result is not
// finite if the offset is not. Precondition: the grid has at least 2 columns and 2 rows.
PosePoint position_with_offset(const HeatPeak& peak, const HeatGrid& grid,
                               std::span<const float> offsets, size_t index, Size input) noexcept;

}  // namespace weir::detection
