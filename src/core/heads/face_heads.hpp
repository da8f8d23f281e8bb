// Heads of face detectors: YuNet and UltraFace.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// Class, objectness, box and five key points of each cell of three grids.
extern const Family kYunet;
// Decoded boxes, and boxes relative to prior boxes.
extern const Family kUltraface, kUltrafaceRaw;

}  // namespace weir::heads
