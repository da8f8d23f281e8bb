// BenchPlan: the engines that accept a model, and the thread counts, batch sizes and options to
// measure.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench/bench_process.hpp"
#include "commands.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct BenchCase {
  std::string engine;
  int threads = 1, batch = 1;
  std::string custom;            // "": the engine's defaults
  std::vector<Measured> rounds;  // the successful rounds
  std::optional<Error> error;    // once set, the case does not run again
  bool is_dropped = false;       // not reported either: its options have no effect
};

struct Refusal {
  std::string cases;  // an engine, or one with these options
  Error error;
};

struct BenchPlan {
  std::vector<BenchCase> cases;
  std::vector<Refusal> refused;        // engines for such a file that are unusable
  std::vector<std::string> unrelated;  // usable engines for other files
};

// Opens modules but no model. MODEL_NOT_FOUND without a model.
Result<BenchPlan> plan_bench(const BenchOptions& options);

}  // namespace weir::app
