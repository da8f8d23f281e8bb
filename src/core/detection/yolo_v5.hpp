// Heads of YOLOv5: rows of centre x, centre y, width, height, objectness and one score per class.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/detection/candidate.hpp"

namespace weir::detection {

// The unit of the coordinates of a YOLO head.
enum class YoloUnit {
  Picture,  // 0 to 1 across the picture
  Pixels    // of the model's input
};

// Returns the rows whose probability (best class times objectness) is above `threshold`, in their
// order. Boxes and probabilities that are not finite are left out.
Candidates decode_yolov5(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, PictureSize picture);
// Rows that a YOLOv5 or YOLOv8 model of this input size has: `anchors` (3 or 1) of each cell of
// the grids with 32, 16 and 8 pixels a cell.
size_t yolo_rows(PictureSize picture, size_t anchors) noexcept;

}  // namespace weir::detection
