// Finds the engine for shared objects with callbacks of NNStreamer's interface.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::custom {

// Called by the NNStreamer compatibility library when it is loaded.
void set_class_engine(const weir_engine& (*engine)()) noexcept;

// The engine that runs such files. MODULE_REFUSED if that library is missing.
Result<const weir_engine*> class_engine();

}  // namespace weir::custom
