// Heads of the YOLO models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// v8, v9, v11 and v12: one anchor a cell, no objectness.
extern const Family kYolov8;

}  // namespace weir::heads
