// Head of PoseNet: heat maps, offsets, and vectors along the skeleton.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// Several persons if the model has the vectors between key points, otherwise the best one.
extern const Family kPosenet;

}  // namespace weir::heads
