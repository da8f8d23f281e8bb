// `weir run --service`: a pipeline as a service of systemd.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "commands.hpp"

namespace weir::app {

// Like run(), and reports to the service manager that the pipeline plays, stops and lives
// (ServiceNotifier).
int run_as_service(const RunOptions& options);

}  // namespace weir::app
