// Runs a case of `weir bench` in a child process, so that its memory is measured separately and a
// crash or hang fails only that case.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "commands.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct Measured {
  double ms = 0;                   // median time of one frame
  double low_ms = 0, high_ms = 0;  // a tenth of the frames took less, and a tenth took more
  double load_ms = 0;
  double mib = 0;  // peak resident memory above that at the start
  // From the model's metadata: the engine that runs the lowered graph, or "none: " and the reason;
  // "" if lowering was not requested.
  std::string lowering;
};

// The case's own error, or WORKER_ENDED, WORKER_TIMEOUT, WORKER_NOT_STARTED.
Result<Measured> run_case(const BenchCaseOptions& options);

}  // namespace weir::app
