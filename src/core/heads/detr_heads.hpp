// Heads of detectors that give a set of objects: DETR, RT-DETR, and those that end in labels, boxes
// and scores.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kDetr;    // logits with a class "no object", boxes
extern const Family kRtDetr;  // logits or probabilities, boxes
extern const Family kLabelsBoxesScores;

}  // namespace weir::heads
