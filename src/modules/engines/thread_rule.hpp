// Chooses the number of threads for one invoke when the user does not: a rule on the size of the
// model, never a measurement.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstdint>

namespace weir::engine {

// The work of one invoke, estimated from the model.
struct Work {
  double multiplications = 0;  // each with its addition
  double weights = 0;          // values that each invoke reads once
  uint32_t operators = 0;      // convolutions and matrix products; 0 = unknown
};

// When threads pay off, in multiplications.
struct ThreadCosts {
  // Average per operator, and for the whole invoke, for each thread: with fewer, waking the threads
  // and waiting for them takes longer than they save.
  double of_operator, of_invoke;
  // How many take as long as reading one weight from memory.
  double of_weight;
};

// Returns 1 to `cores`; 1 for unknown work.
inline int threads_for(const Work& work, const ThreadCosts& costs, int cores) {
  if (work.operators == 0) return 1;
  const double all = work.multiplications + costs.of_weight * work.weights;
  const double threads = std::min(all / work.operators / costs.of_operator, all / costs.of_invoke);
  if (!(threads >= 1)) return 1;  // also true for NaN: sizes come from the model file
  return static_cast<int>(std::clamp(threads, 1.0, static_cast<double>(std::max(cores, 1))));
}

}  // namespace weir::engine
