// DirectModel: a model that a program invokes directly, without a pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/direct/call_thread.hpp"
#include "core/direct/inputs.hpp"
#include "core/direct/results.hpp"
#include "core/infer/model/model.hpp"

namespace weir::direct {

// Finds an engine by name or alias; "", "auto", "any": by the model's file names.
Result<const weir_engine*> engine_for(const std::string& name, std::span<const std::string> paths);

// What the WORKER_TIMEOUT of an invoke says that exceeded its own limit. Others are refused because
// of another call.
inline constexpr char kInvokeTimedOut[] = "the model timed out";

// Any thread may call; calls of one model are serialised.
class DirectModel {
 public:
  using Limit = std::chrono::nanoseconds;  // 0: none

  static Result<std::unique_ptr<DirectModel>> open(const weir_engine& engine,
                                                   const infer::OpenOptions& options);
  DirectModel(const DirectModel&) = delete;
  DirectModel& operator=(const DirectModel&) = delete;

  const infer::Model& model() const noexcept;
  // The current tensors, after reshape(). Names are valid as long as the model.
  std::vector<weir_tensor_info> inputs() const;
  std::vector<weir_tensor_info> outputs() const;

  // Sets shapes where the model leaves them open, until the next reshape(). Only type, rank and
  // shape of `wanted` are read; WEIR_RANK_UNKNOWN keeps the model's.
  Status reshape(const std::vector<weir_tensor_info>& wanted);

  // Limits each later call, including the wait for other calls. The engine cannot be interrupted:
  // after WORKER_TIMEOUT its invoke continues in its own memory, and until it ends each call fails
  // with WORKER_TIMEOUT.
  void set_limit(Limit limit) noexcept;

  struct Outcome {
    bool dropped = false;  // the engine has no output for these inputs
    Results results;
  };
  // `into`: empty, or memory for each output.
  Result<Outcome> invoke(std::span<const weir_tensor> inputs, std::span<weir_tensor> into = {});
  // `inputs`: those of the first frame, then of the second and so on. Runs all frames in one
  // invoke. BATCH_UNSUPPORTED if there is no outermost axis for them.
  Result<Outcome> invoke_batch(std::span<const weir_tensor> inputs, uint32_t frames);

 private:
  struct Core;
  class Turn;
  struct Job;
  explicit DirectModel(std::shared_ptr<Core> core) : core_(std::move(core)) {}
  Result<Outcome> run(Turn& turn, Inputs inputs, const std::vector<weir_tensor_info>& outputs,
                      std::span<weir_tensor> into);
  MemoryNeeds needs() const noexcept;
  // The model's inputs; `given` tensors of any type if it leaves their number open.
  std::vector<weir_tensor_info> declared(size_t given) const;

  std::shared_ptr<Core> core_;  // shared with an invoke that has timed out
};

}  // namespace weir::direct
