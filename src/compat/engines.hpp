// Engines over filters for NNStreamer's interface.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/abi.h"

namespace weir::compat {

// The engine of a descriptor (const GstTensorFilterFramework*) that is registered; it lives until
// the process ends. Null, with a line in the log, where it cannot be used.
const weir_engine* engine_of(const void* descriptor);

// The engine that runs a shared object which exports NNStreamer_custom: its one model file.
const weir_engine& class_engine();

}  // namespace weir::compat
