// The configuration, with its faults told once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/config/configuration.hpp"
#include "core/config/nnstreamer.hpp"

namespace weir::infer {

// As files and environment are now. A fault is a warning in the log, once in a process.
config::Configuration configuration();
// The same for nnstreamer.ini.
config::NnstreamerConfiguration nnstreamer_configuration();

}  // namespace weir::infer
