// Loads the configuration and logs each of its faults once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/config/configuration.hpp"
#include "core/config/nnstreamer.hpp"

namespace weir::infer {

// The current files and environment. Logs each fault as a warning once per process.
config::Configuration configuration();
// The same for nnstreamer.ini.
config::NnstreamerConfiguration nnstreamer_configuration();

}  // namespace weir::infer
