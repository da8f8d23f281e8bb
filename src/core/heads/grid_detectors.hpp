// Heads of small detectors: FastestDet and NanoDet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kFastestDet, kNanoDet;

}  // namespace weir::heads
