// Masks of objects from prototype masks: the sigmoid of their weighted sum (YOLACT, 2019).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "weir/detection.hpp"

namespace weir::detection {

// Prototype masks over the whole input picture, in one of two orders of memory: one after the
// other, or all values of a cell together.
struct Prototypes {
  std::span<const float> values;  // width * height * count
  size_t width = 0, height = 0, count = 0;
  bool are_packed = false;  // all values of a cell together
};

class InstanceMasks {
 public:
  // Writes probabilities 0 to 255 of an object whose box is in cells of the prototypes, row after
  // row over the box: bilinear interpolation of the weighted sums between the centres of cells,
  // those at the border beyond it. A box of no extent and sums that are not numbers give 0.
  // Preconditions: `weights` has as many numbers as there are prototypes, `out` width * height.
  void draw(const Prototypes& prototypes, std::span<const float> weights, const Box& box,
            uint32_t width, uint32_t height, std::span<uint8_t> out);

 private:
  struct Region {  // of cells that the box needs
    size_t left = 0, top = 0, width = 0, height = 0;
  };
  void sum(const Prototypes& prototypes, std::span<const float> weights, const Region& region);

  std::vector<float> sums_;  // of the region
};

}  // namespace weir::detection
