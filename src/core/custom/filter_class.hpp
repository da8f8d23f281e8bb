// The engine cpp: classes that a program or a library registered by name
// (docs/compatibility/filter.md 4.12).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::custom {

// model=NAME[,lib.so]
const weir_engine& cpp_engine();

}  // namespace weir::custom
