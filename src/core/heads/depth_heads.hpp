// The head of networks that give a depth for each pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kDepthMap;

}  // namespace weir::heads
