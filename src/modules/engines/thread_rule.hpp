// How many threads an engine uses for one invoke where the user does not say: a rule on the size of
// the model, never a measurement.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstdint>

namespace weir::engine {

// What one invoke computes, estimated from the model.
struct Work {
  double multiplications = 0;  // and the additions that go with them
  double weights = 0;          // numbers that are read once for each invoke
  uint32_t operators = 0;      // convolutions and matrix products; 0 = unknown
};

// When an engine's threads pay off, in multiplications.
struct ThreadCosts {
  // Of an operator, on average, and of the whole invoke, for each thread: with fewer, waking the
  // threads and waiting for them takes longer than they save.
  double of_operator, of_invoke;
  // As many as take the time of reading one weight from memory.
  double of_weight;
};

// 1 to `cores`; 1 where the work is unknown.
inline int threads_for(const Work& work, const ThreadCosts& costs, int cores) {
  if (work.operators == 0) return 1;
  const double all = work.multiplications + costs.of_weight * work.weights;
  const double threads = std::min(all / work.operators / costs.of_operator, all / costs.of_invoke);
  if (!(threads >= 1)) return 1;  // not a number, too: sizes come from the model's file
  return static_cast<int>(std::clamp(threads, 1.0, static_cast<double>(std::max(cores, 1))));
}

}  // namespace weir::engine
