// FilterThreads: how many threads the engine of a tensor_filter gets.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/infer/queue/thread_budget.hpp"
#include "elements/tensor_filter/filter_settings.hpp"

namespace weir {

// The workers and their engine threads that the user requests. NumThreads in `custom` takes
// precedence over `threads`.
infer::ThreadUse thread_use(const FilterSettings& settings);

// The claim of a filter in the thread budget of the process. Claim it in READY: a pipeline brings
// all elements to READY before the first model is opened.
class FilterThreads {
 public:
  void claim(const FilterSettings& settings) {
    claim_ = infer::ThreadBudget::of_process().claim(thread_use(settings));
  }
  void release() { claim_ = {}; }
  // The threads for weir_open; 0 = the engine chooses.
  int chosen() const { return infer::ThreadBudget::of_process().threads_of(claim_); }

 private:
  infer::ThreadBudget::Claim claim_;
};

}  // namespace weir
