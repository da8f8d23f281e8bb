// FilterSettings: the values of the properties of tensor_filter, and the threads that they ask for.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/filter/model_description.hpp"
#include "core/infer/queue/thread_budget.hpp"
#include "core/isolate/isolation.hpp"
#include "weir/result.hpp"

namespace weir {

// What happens to a frame that arrives while the model is busy. Unset: one worker runs on the
// streaming thread.
enum class WhenBusyChoice { Unset, Block, DropNew, DropOld };

enum class IsolateChoice { None, Process };

struct FilterSettings : DeclaredTensors {
  bool silent = true;
  std::string framework = "auto";
  std::string model;
  std::string fallback;  // the model that runs when `model` has no result; "" = none
  std::string custom;
  int latency = 0;
  int throughput = 0;
  bool qos = false;
  uint32_t batch_size = 1;              // frames in one invoke
  uint64_t batch_timeout = 10'000'000;  // ns that a frame waits for others
  std::string accelerator;
  bool is_updatable = false;
  std::optional<std::string> shared_tensor_filter_key;
  std::string config_file;
  uint32_t suspend = 0;  // ms; 0 = never
  uint32_t workers = 1;
  int threads = 0;  // of the engine, per worker; 0 = automatic
  WhenBusyChoice when_busy = WhenBusyChoice::Unset;
  IsolateChoice isolate = IsolateChoice::None;
  uint32_t isolate_timeout = 10000;  // milliseconds; 0 = none
  uint32_t isolate_memory = 0;       // MiB; 0 = no limit
  isolate::OnCrash on_crash = isolate::OnCrash::Restart;
  std::string crash_folder;
  uint64_t max_bytes = 0;  // of held frames; 0 = no limit
  uint64_t deadline = 0;   // ns after the running time of a frame; 0 = none
  bool latency_report = false;
  bool invoke_async = false;
  uint32_t invoke_rows = 0;  // of a batch, per invoke; 0 = all
  uint32_t invoke_threads = 1;
  uint32_t async_timeout = 60000;  // milliseconds; 0 = none
};

// Rejects lists that cannot be parsed, whatever the model is.
Status check_lists(const FilterSettings& settings);

// The workers and their engine threads that the user requests. NumThreads in `custom` takes
// precedence over `threads`.
infer::ThreadUse thread_use(const FilterSettings& settings);

// FilterThreads: the claim of a filter in the thread budget of the process. Claim it in READY: a
// pipeline brings all elements to READY before the first model is opened.
class FilterThreads {
 public:
  void claim(const FilterSettings& settings) {
    claim_ = infer::ThreadBudget::of_process().claim(thread_use(settings));
  }
  void release() { claim_ = {}; }
  // The threads for weir_open; 0 = the engine chooses.
  int chosen() const { return infer::ThreadBudget::of_process().count_threads(claim_); }

 private:
  infer::ThreadBudget::Claim claim_;
};

}  // namespace weir
