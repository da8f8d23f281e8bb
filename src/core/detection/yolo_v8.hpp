// Heads of YOLOv8: rows of centre x, centre y, width, height, one score per class and, for oriented
// boxes, the angle. Models give columns: transpose their output first.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/detection/yolo_v5.hpp"

namespace weir::detection {

// Returns the rows whose best class is above `threshold`, in their order. Boxes and scores that are
// not finite are left out.
Candidates decode_yolov8(std::span<const float> rows, size_t classes, float threshold,
                         YoloUnit unit, PictureSize picture);
// The same for oriented boxes: x and y of the candidates are the centre.
Candidates decode_yolov8_obb(std::span<const float> rows, size_t classes, float threshold,
                             YoloUnit unit, PictureSize picture);

}  // namespace weir::detection
