// BenchPlan: the engines that accept a model, and the thread counts, batch sizes and options to
// measure.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

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

struct BenchCase {
  std::string engine;
  int threads = 1, batch = 1;
  std::string custom;            // "": the engine's defaults
  std::vector<Measured> rounds;  // the successful rounds
  std::optional<Error> error;    // once set, the case does not run again
  bool is_dropped = false;       // not reported either: its options have no effect
};

struct UnusableEngine {
  std::string cases;  // an engine, or one with these options
  Error error;
};

struct BenchPlan {
  std::vector<BenchCase> cases;
  std::vector<UnusableEngine> refused;  // engines for such a file that are unusable
  std::vector<std::string> unrelated;   // usable engines for other files
};

// Opens modules but no model. MODEL_NOT_FOUND without a model.
Result<BenchPlan> plan_bench(const BenchOptions& options);

// Runs a case in a child process, so that its memory is measured separately and a crash or hang
// fails only that case. The case's own error, or WORKER_ENDED, WORKER_TIMEOUT, WORKER_NOT_STARTED.
Result<Measured> run_case(const BenchCaseOptions& options);

}  // namespace weir::app
