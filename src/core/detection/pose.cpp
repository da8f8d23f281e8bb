// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/pose.hpp"
#include "core/tensor/geometry.hpp"

#include <algorithm>
#include <limits>

#include "core/detection/sigmoid.hpp"

namespace weir::detection {
namespace {

// Key points of which one pass over the maps keeps the best values in registers or on the stack.
constexpr size_t kTogether = 32;

struct Best {
  float value[kTogether];
  float probability[kTogether];
  uint32_t cell[kTogether];
};

// Sigmoids are compared, not the values: several large values have the sigmoid 1, and then the
// first wins. A value that is not above the greatest so far cannot have a greater sigmoid.
void find_logits(const float* values, size_t stride, size_t cells, size_t points,
                 Best* best) noexcept {
  for (size_t cell = 0; cell < cells; ++cell, values += stride)
    for (size_t i = 0; i < points; ++i) {
      if (!(values[i] > best->value[i])) continue;
      best->value[i] = values[i];
      const float probability = sigmoid(values[i]);
      if (!(probability > best->probability[i])) continue;
      best->probability[i] = probability;
      best->cell[i] = static_cast<uint32_t>(cell);
    }
}

void find_probabilities(const float* values, size_t stride, size_t cells, size_t points,
                        Best* best) noexcept {
  for (size_t cell = 0; cell < cells; ++cell, values += stride)
    for (size_t i = 0; i < points; ++i) {
      if (!(values[i] > best->value[i])) continue;
      best->value[i] = values[i];
      best->cell[i] = static_cast<uint32_t>(cell);
    }
}

}  // namespace

void find_peaks(std::span<const float> maps, const HeatGrid& grid, Heat heat,
                std::span<HeatPeak> peaks) noexcept {
  const size_t cells = grid.width * grid.height;
  for (size_t first = 0; first < grid.points; first += kTogether) {
    const size_t points = std::min(kTogether, grid.points - first);
    Best best;
    std::fill_n(best.value, kTogether, -std::numeric_limits<float>::infinity());
    std::fill_n(best.probability, kTogether, 0.f);
    std::fill_n(best.cell, kTogether, 0u);
    if (heat == Heat::Logit)
      find_logits(maps.data() + first, grid.points, cells, points, &best);
    else
      find_probabilities(maps.data() + first, grid.points, cells, points, &best);
    const float* found = heat == Heat::Logit ? best.probability : best.value;
    for (size_t i = 0; i < points; ++i)
      peaks[first + i] = {static_cast<uint32_t>(best.cell[i] % grid.width),
                          static_cast<uint32_t>(best.cell[i] / grid.width),
                          best.value[i] == -std::numeric_limits<float>::infinity() ? 0 : found[i]};
  }
}

PosePoint position_with_offset(const HeatPeak& peak, const HeatGrid& grid,
                               std::span<const float> offsets, size_t index, Size input) noexcept {
  const float* offset = offsets.data() + (peak.row * grid.width + peak.column) * 2 * grid.points;
  const auto place = [](uint32_t cell, size_t cells, uint32_t pixels) {
    return static_cast<float>(cell) / static_cast<float>(cells - 1) * static_cast<float>(pixels);
  };
  return {place(peak.column, grid.width, input.width) + offset[grid.points + index],
          place(peak.row, grid.height, input.height) + offset[index]};
}

}  // namespace weir::detection
