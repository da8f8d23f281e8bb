// Heads of MediaPipe's detectors of faces, palms and persons, which are relative to anchors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kBlazeface;           // 6 key points
extern const Family kPalmDetection;       // 7 key points, rotated boxes
extern const Family kBlazeposeDetection;  // 4 key points, rotated boxes of whole persons

}  // namespace weir::heads
