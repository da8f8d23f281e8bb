// Candidate: one object that a detection head reports, before non-maximum suppression.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

namespace weir::detection {

struct Candidate {
  // Pixels of the model's input: top left corner and size. Neither is clamped to the picture.
  float x = 0, y = 0, width = 0, height = 0;
  float score = 0;
  int32_t class_index = -1;  // -1: the head has no classes
  uint32_t row = 0;          // of the head's tensors, to find values that belong to the object
  float angle = 0;           // clockwise about the centre, in radians; 0 for upright boxes

  bool is_finite() const noexcept {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(width) && std::isfinite(height) &&
           std::isfinite(angle) && std::isfinite(score);
  }
  bool operator==(const Candidate&) const = default;
};
using Candidates = std::vector<Candidate>;

}  // namespace weir::detection
