// Worker: one process with one open model and one session.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "core/isolate/calls.hpp"
#include "core/isolate/channel.hpp"
#include "core/isolate/confinement.hpp"
#include "core/isolate/shared_arena.hpp"
#include "core/isolate/worker_model_info.hpp"
#include "core/isolate/worker_process.hpp"
#include "weir/abi.h"

namespace weir::isolate {

struct WorkerSettings {
  OpenCall open;
  // For an invoke; ten times as long for rare calls: start, first invoke, shapes, orders. 0 = no
  // limit.
  std::chrono::milliseconds timeout{10000};
  std::chrono::milliseconds min_for_start{60000};  // minimum for the start, if `timeout` is short
  uint64_t memory_mib = 0;                         // 0 = no limit
  int stop = -1;  // borrowed; readable when the result is no longer needed: CANCELLED
};

// Used by one thread at a time. After an error, alive() tells whether the worker ended.
class Worker {
 public:
  // Waits until the model is open. The process ends with the calling thread. `cancel` (borrowed)
  // becomes readable to end the wait. Errors: WORKER_NOT_STARTED, WORKER_ENDED, WORKER_TIMEOUT,
  // CANCELLED, or those of the engine or the module library.
  static Result<std::unique_ptr<Worker>> start(const WorkerSettings& settings, int cancel);
  // Gives a live worker up to two seconds to close its model.
  ~Worker();

  const std::shared_ptr<const WorkerModelInfo>& facts() const noexcept { return facts_; }
  const Confinement& confinement() const noexcept { return confinement_; }
  bool alive() const noexcept { return alive_; }
  // Returns what the last resolve() gave; threads is 0 if the engine does not report it.
  const weir_execution& execution() const noexcept { return execution_; }
  // True if it ended between calls; alive() is then false.
  bool ended_idle();
  // The error for a worker that ended_idle().
  Error idle_end();

  // Same as the functions of weir_engine; does not change names in `out`.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  Status control(int op, const weir_option* option);
  // Returns the engine's return value. Inputs outside `arena`, or not aligned and padded as the
  // engine requires, are copied; `copied` counts their bytes and those of the outputs.
  Result<int> invoke(const weir_frame& in, weir_frame& out, const SharedArena& arena,
                     uint64_t* copied);

 private:
  explicit Worker(const WorkerSettings& settings) : settings_(settings) {}
  Status open(int cancel);
  Error about_model(Error error) const;
  // The end of a call that has `times` the time-out; sets limit_.
  io::Deadline deadline(int times);
  // Sends the content of writer_ and waits for a reply of `kind`.
  Status ask(Kind kind, const io::Deadline& until, const std::string& doing);
  Error lost(Passage passage, const std::string& doing);
  Error invalid_message(const std::string& doing, const std::string& how);
  Status share(const std::shared_ptr<SharedBlock>& block);
  void forget_blocks_that_are_gone();
  Result<InputCall> place_input(size_t index, const weir_tensor& tensor, const SharedArena& arena,
                                uint64_t* copied);
  Status place_outputs(const weir_frame& out, uint64_t* end);
  Status reserve_output(uint64_t bytes);
  void write_frame(const weir_frame& in, const weir_frame& out,
                   const std::vector<InputCall>& inputs);
  Result<std::vector<OutputResponse>> read_outputs(const weir_frame& out, MessageReader* response,
                                                   uint64_t* end);
  Status fetch_outputs(uint64_t end);
  Status take_outputs(weir_frame& out, uint64_t end, uint64_t* copied, MessageReader* response,
                      bool in_block);
  std::string on_frame() const;

  const WorkerSettings settings_;
  std::unique_ptr<WorkerProcess> process_;
  Channel channel_;
  std::shared_ptr<const WorkerModelInfo> facts_;
  weir_execution execution_{sizeof(weir_execution), 0, 0};
  Confinement confinement_;
  std::chrono::milliseconds limit_{};  // of the present call
  bool alive_ = true;
  uint64_t invokes_ = 0;
  MessageWriter writer_;
  Message response_;
  std::vector<std::weak_ptr<SharedBlock>> shared_;     // known to the worker
  std::vector<uint64_t> shared_ids_;                   // of shared_
  std::vector<std::shared_ptr<SharedBlock>> staging_;  // for inputs outside the arena
  std::shared_ptr<SharedBlock> output_;
  std::vector<uint64_t> places_;  // of the outputs in output_
};

}  // namespace weir::isolate
