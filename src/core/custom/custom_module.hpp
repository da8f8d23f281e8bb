// The engine custom: a user's shared object is the filter (docs/compatibility/filter.md 4.10).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::custom {

// model=lib.so[,file,...]: the file exports weir_module_entry with one engine, which gets the other
// files; or the only file exports NNStreamer_custom.
const weir_engine& custom_engine();

}  // namespace weir::custom
