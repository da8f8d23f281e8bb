// Heads of MediaPipe's landmark networks, which look at one hand, face or person.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kBlazepose;      // 33 points with visibility
extern const Family kFaceLandmarks;  // 468 points, or 478 with irises
extern const Family kHandLandmarks;  // 21 points; class 0 = left, 1 = right

}  // namespace weir::heads
