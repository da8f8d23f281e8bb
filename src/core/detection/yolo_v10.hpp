// Heads of YOLOv10: rows of x1, y1, x2, y2 (0 to 1 across the picture), score and class, sorted by
// score and already free of duplicates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/detection/candidate.hpp"

namespace weir::detection {

inline constexpr size_t kYolov10Row = 6;

// Returns the rows before the first with a score below `threshold`, in their order. Rows with
// values that are not finite are left out.
Candidates decode_yolov10(std::span<const float> rows, float threshold, PictureSize picture);

}  // namespace weir::detection
