// DirectModel: a model that a program opens and invokes itself, with no pipeline around it.
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
#include "core/infer/model.hpp"

namespace weir::direct {

// By name or alias; "", "auto", "any": by the names of the model's files.
Result<const weir_engine*> engine_for(const std::string& name, std::span<const std::string> paths);

// Any thread may call; calls of one model wait for each other.
class DirectModel {
 public:
  using Limit = std::chrono::nanoseconds;  // 0: none

  static Result<std::unique_ptr<DirectModel>> open(const weir_engine& engine,
                                                   const infer::OpenOptions& options);
  DirectModel(const DirectModel&) = delete;
  DirectModel& operator=(const DirectModel&) = delete;

  const infer::Model& model() const noexcept;
  // As they are now, after reshape(). Names live as long as the model.
  std::vector<weir_tensor_info> inputs() const;
  std::vector<weir_tensor_info> outputs() const;

  // Shapes in the place of what the model leaves open, until the next reshape(). Only type, rank
  // and shape of `wanted` are read; WEIR_RANK_UNKNOWN: as the model says.
  Status reshape(const std::vector<weir_tensor_info>& wanted);

  // Of each later call, waiting for others included. The engine cannot be stopped: after
  // WORKER_TIMEOUT its invoke goes on, in memory of its own, and until it ends each call is
  // WORKER_TIMEOUT too.
  void set_limit(Limit limit) noexcept;

  struct Outcome {
    bool dropped = false;  // the engine gives nothing for these inputs
    Results results;
  };
  // `into`: empty, or memory for each output.
  Result<Outcome> invoke(std::span<const weir_tensor> inputs, std::span<weir_tensor> into = {});
  // `inputs`: those of the first frame, then those of the second, ... All frames go through the
  // engine at once. BATCH_UNSUPPORTED where no outermost axis can hold them.
  Result<Outcome> invoke_batch(std::span<const weir_tensor> inputs, uint32_t frames);

 private:
  struct Core;
  class Turn;
  struct Job;
  explicit DirectModel(std::shared_ptr<Core> core) : core_(std::move(core)) {}
  Result<Outcome> run(Turn& turn, Inputs inputs, const std::vector<weir_tensor_info>& outputs,
                      std::span<weir_tensor> into);
  MemoryNeeds needs() const noexcept;
  // The model's inputs; `given` tensors of any kind where it leaves their number open.
  std::vector<weir_tensor_info> declared(size_t given) const;

  std::shared_ptr<Core> core_;  // an invoke that nobody waits for owns it too
};

}  // namespace weir::direct
