// Heads of YOLO v3, v5 and v7 whose boxes are not decoded: one output for each grid of cells.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kYolov3Grids, kYolov5Grids, kYolov7Grids;

}  // namespace weir::heads
