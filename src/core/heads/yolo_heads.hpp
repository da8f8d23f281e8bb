// Heads of the YOLO models whose coordinates are decoded, and of YOLOX.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// v8, v9, v11 and v12: one anchor a cell, no objectness.
extern const Family kYolov8, kYolov8Segmentation, kYolov8Pose, kYolov8Obb;
// v3, v5 and v7: three anchors a cell, objectness.
extern const Family kYolov5, kYolov5Segmentation;
// YOLOX and v6: one anchor a cell, objectness.
extern const Family kYolox;

}  // namespace weir::heads
