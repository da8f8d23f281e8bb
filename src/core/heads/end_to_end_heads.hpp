// Heads of detectors that have removed duplicates themselves and give one row for each object.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// Rows of x1, y1, x2, y2, score, class.
extern const Family kYolov10;
// Rows of picture, x1, y1, x2, y2, class, score.
extern const Family kYolov7EndToEnd;
// Rows of picture, class, score, x1, y1, x2, y2: the layer DetectionOutput of Caffe and OpenVINO.
extern const Family kDetectionOutput;

}  // namespace weir::heads
