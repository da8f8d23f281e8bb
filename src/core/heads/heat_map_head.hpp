// Head of networks that output one heat map for each key point, as HRNet does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kHeatMaps;

}  // namespace weir::heads
