// Engines that run filters of NNStreamer's interface.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::compat {

// The engine of a registered descriptor (const GstTensorFilterFramework*); valid until the process
// ends. Null, with a log line, when it cannot be used.
const weir_engine* engine_of(const void* descriptor);

// The engine for a shared object that exports NNStreamer_custom, which is its only model file.
const weir_engine& class_engine();

}  // namespace weir::compat
