// Heads of SSD models: raw, and post-processed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kSsd;             // boxes relative to anchors, scores of classes
extern const Family kSsdPostprocess;  // TFLite_Detection_PostProcess

}  // namespace weir::heads
