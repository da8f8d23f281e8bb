// Shared objects with callbacks of NNStreamer's interface: who runs them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::custom {

// Brought by the library for what was built for NNStreamer, when it is loaded.
void set_class_engine(const weir_engine& (*engine)()) noexcept;

// The engine whose model is such a file. MODULE_REFUSED where that library is missing.
Result<const weir_engine*> class_engine();

}  // namespace weir::custom
