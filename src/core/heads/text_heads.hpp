// Heads that find text (DB) and read it (CTC).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kCtc;  // text recognition: characters of a line
extern const Family kDb;   // text detection: a map of probabilities

}  // namespace weir::heads
