// The engines that need no module file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::custom {

// The engines that need no module file.

const weir_module& builtin_engines();

// The engine custom: a user's shared object is the filter (docs/compatibility/filter.md 4.10).

// model=lib.so[,file,...]: the file exports weir_module_entry with one engine, which gets the other
// files; or the only file exports NNStreamer_custom.
const weir_engine& custom_engine();

// The engine cpp: classes that a program or a library registered by name
// (docs/compatibility/filter.md 4.12).

// model=NAME[,lib.so]
const weir_engine& cpp_engine();

}  // namespace weir::custom
