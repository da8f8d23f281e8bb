// The engine custom: a shared object of the user's is the filter (specification 4.10).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::custom {

// model=lib.so[,file,...]: the file exports weir_module_entry with one engine, which gets the other
// files. Or the one file exports NNStreamer_custom.
const weir_engine& custom_engine();

}  // namespace weir::custom
