// How many threads the engine of a tensor_filter gets.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/infer/thread_budget.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// What the user asks for: workers, and their threads by `threads` or NumThreads in `custom`, which
// wins.
infer::ThreadUse thread_use(const FilterSettings& settings);

// A filter's place among those of the process, from READY on: a pipeline brings all of its elements
// to READY before the first model is opened.
class FilterThreads {
 public:
  void claim(const FilterSettings& settings) {
    claim_ = infer::ThreadBudget::of_process().claim(thread_use(settings));
  }
  void release() { claim_ = {}; }
  // For weir_open; 0 = the engine may choose.
  int chosen() const { return infer::ThreadBudget::of_process().threads_of(claim_); }

 private:
  infer::ThreadBudget::Claim claim_;
};

}  // namespace weir
