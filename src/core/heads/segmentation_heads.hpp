// Heads of networks that give a class for each pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kDeepLab;   // scores of all classes, or of one
extern const Family kClassMap;  // numbers of classes

}  // namespace weir::heads
