// A case of `weir bench` in a process of its own: what it costs in memory is its own, and one that
// crashes or hangs is only a case that failed.
#pragma once
#include <string>

#include "commands.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct Measured {
  double ms = 0;  // of one frame, the median
  double load_ms = 0;
  double mib = 0;  // resident at most, above what the process had before
  // Of the model's metadata: the engine that runs the graph translated, "none: " and why not; "" of
  // a model that was not to be.
  std::string lowering;
};

// The case's own error; WORKER_ENDED, WORKER_TIMEOUT, WORKER_NOT_STARTED.
Result<Measured> run_case(const BenchCaseOptions& options);

}  // namespace weir::app
