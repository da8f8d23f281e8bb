// BatchRunner: runs gathered frames as one invoke and gives each its part of the outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/infer/batch_axis.hpp"
#include "core/infer/batch_job.hpp"
#include "core/infer/batch_layout.hpp"
#include "core/infer/block_pool.hpp"

namespace weir::infer {

// With how many frames a batch that is not full is run: as many as there are, or padded to all.
// Padding costs the share of the frames that are not there; to run fewer, the engine must change
// its shapes and change them back for the next full batch.
size_t frames_to_run(size_t there, const BatchShapes& shapes, std::chrono::nanoseconds reshape,
                     std::optional<std::chrono::nanoseconds> full_invoke) noexcept;

// Memory that the model wants for inputs: of weir_model_info.
struct InputMemory {
  size_t alignment = 1, padding = 0;
};

class BatchRunner {
 public:
  // true: filled, false: dropped; Session::invoke.
  using Invoke = std::function<Result<bool>(const weir_frame&, weir_frame&)>;

  // `reshape`: what it costs the engine to change its shapes, as measured.
  BatchRunner(BatchShapes shapes, InputMemory memory, std::chrono::nanoseconds reshape,
              Invoke invoke);

  // Ends every job. 1 to batch_size jobs, whose inputs have the shapes of one frame. What is
  // missing to a length that the model fixes, or to a padded batch, is the last frame again; its
  // outputs are thrown away. The frames of a run have no common time: pts is -1.
  void run(BatchJobs& jobs);

  const BatchShapes& shapes() const noexcept { return shapes_; }

 private:
  void refuse_wrong_sizes(BatchJobs& jobs);
  Status describe_inputs(const BatchJobs& jobs, size_t slots);
  Status describe_input(const BatchJobs& jobs, size_t index, size_t slots);
  Status describe_outputs(size_t slots);
  Result<bool> invoke(size_t slots);
  Status hand_out(BatchJobs& jobs, size_t slots);
  Result<uint64_t> slice(size_t slot, size_t slots, std::shared_ptr<void>* owner);
  void run_checked(BatchJobs& jobs);

  const BatchShapes shapes_;
  const InputMemory memory_;
  const std::chrono::nanoseconds reshape_;
  const Invoke invoke_;
  std::vector<BatchLayout> input_layouts_, output_layouts_;
  std::vector<BlockPool> input_pools_;
  std::vector<size_t> output_offsets_, piece_offsets_;  // of each output in a block of all
  std::optional<BlockPool> output_pool_, piece_pool_;   // whole batches; frames cut out of them
  std::vector<weir_tensor> inputs_, outputs_, slices_;
  std::vector<std::shared_ptr<std::byte>> input_blocks_;  // behind inputs_
  std::shared_ptr<std::byte> output_block_;               // behind outputs_
  uint64_t copied_ = 0;                                   // bytes of each frame, into the batch
  BatchRun run_;
  std::optional<std::chrono::nanoseconds> full_invoke_;  // the last one
};

}  // namespace weir::infer
