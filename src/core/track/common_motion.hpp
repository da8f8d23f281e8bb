// common_motion: how far the camera moved, from boxes alone.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "weir/detection.hpp"

namespace weir::track {

struct Shift {
  float x = 0, y = 0;  // pixels
};

// The shift that brings the most predicted boxes onto boxes of nearly the same size: the median of
// those that agree. No shift where fewer than three agree or less than half of them do.
Shift common_motion(std::span<const Box> predicted, std::span<const Box> boxes);

}  // namespace weir::track
