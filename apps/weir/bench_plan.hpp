// What `weir bench` measures: which engines take a model, and with what threads, batches, options.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench_process.hpp"
#include "commands.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct BenchCase {
  std::string engine;
  int threads = 1, batch = 1;
  std::string custom;            // "": the engine's defaults
  std::vector<Measured> rounds;  // of those that went well
  std::optional<Error> error;    // it is run no more
  bool is_dropped = false;       // nor is it a case: its options change nothing
};

struct Refusal {
  std::string cases;  // an engine, or one with such options
  Error error;
};

struct BenchPlan {
  std::vector<BenchCase> cases;
  std::vector<Refusal> refused;        // engines for such a file that cannot be used
  std::vector<std::string> unrelated;  // usable engines for other files
};

// Opens modules, no model. MODEL_NOT_FOUND without a model.
Result<BenchPlan> plan_bench(const BenchOptions& options);

}  // namespace weir::app
