// Heads of networks that output the key points of persons: MoveNet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kMovenet;           // one person
extern const Family kMovenetMultipose;  // up to six

}  // namespace weir::heads
