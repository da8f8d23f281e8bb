// BatchRunner: runs collected frames as one invoke and distributes the outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/infer/batch/batch_axis.hpp"
#include "core/infer/queue/batch_job.hpp"
#include "core/infer/queue/block_pool.hpp"
#include "core/tensor/element_type.hpp"
#include "weir/abi.h"

namespace weir::infer {

// Frame `slot` of a batch of `slots` frames has `parts` parts of `part_bytes` bytes; part p begins
// at (p * slots + slot) * part_bytes. There is one part if the batch axis is the outermost.
struct BatchLayout {
  size_t parts = 1;
  size_t part_bytes = 0;

  // `frame`: the tensor of one frame, with all extents known.
  static BatchLayout of(const weir_tensor_info& frame, uint32_t axis) noexcept {
    BatchLayout out;
    out.part_bytes = element_size(static_cast<ElementType>(frame.type));
    for (uint32_t i = 0; i < frame.rank; ++i)
      (i < axis ? out.parts : out.part_bytes) *= static_cast<size_t>(frame.shape[i]);
    return out;
  }
  size_t frame_bytes() const noexcept { return parts * part_bytes; }
  bool in_one_piece() const noexcept { return parts == 1; }

  void put(std::span<const std::byte> frame, size_t slot, size_t slots, std::byte* batch) const {
    for (size_t p = 0; p < parts; ++p)
      std::memcpy(batch + (p * slots + slot) * part_bytes, frame.data() + p * part_bytes,
                  part_bytes);
  }
  void get(const std::byte* batch, size_t slot, size_t slots, std::span<std::byte> frame) const {
    for (size_t p = 0; p < parts; ++p)
      std::memcpy(frame.data() + p * part_bytes, batch + (p * slots + slot) * part_bytes,
                  part_bytes);
  }
};

// The number of frames to run for a partial batch: either the number present, or the full batch
// size with padding. Padding costs the invoke time of the missing frames; running fewer costs the
// engine two changes of shape.
size_t frames_to_run(size_t there, const BatchShapes& shapes, std::chrono::nanoseconds reshape,
                     std::optional<std::chrono::nanoseconds> full_invoke) noexcept;

// The model's requirements for input memory, from weir_model_info, in bytes.
struct InputMemory {
  size_t alignment = 1, padding = 0;
};

class BatchRunner {
 public:
  // Session::invoke; true: filled, false: dropped.
  // `reason`: as in Session::invoke.
  using Invoke = std::function<Result<bool>(const weir_frame&, weir_frame&, InvokeEnd* end)>;

  // `reshape`: the measured time of a shape change in the engine.
  BatchRunner(BatchShapes shapes, InputMemory memory, std::chrono::nanoseconds reshape,
              Invoke invoke);

  // Runs 1 to batch_size jobs, whose inputs have the shapes of one frame, and ends every job. A
  // batch that is padded, or whose length the model fixes, is filled with copies of the last frame,
  // whose outputs are discarded. The frames have no common time, so pts is -1. The batch expires
  // with the last of its frames. A frame for which the response of a server is too late is dropped.
  void run(BatchJobs& jobs);

  const BatchShapes& shapes() const noexcept { return shapes_; }

 private:
  void refuse_wrong_sizes(BatchJobs& jobs);
  Status describe_inputs(const BatchJobs& jobs, size_t slots);
  Status describe_input(const BatchJobs& jobs, size_t index, size_t slots);
  Status describe_outputs(size_t slots);
  Result<bool> invoke(size_t slots, int64_t expires);
  bool is_late(const BatchJob& job) const;
  Status hand_out(BatchJobs& jobs, size_t slots);
  Result<uint64_t> slice(size_t slot, size_t slots, std::shared_ptr<void>* owner);
  void run_checked(BatchJobs& jobs);

  const BatchShapes shapes_;
  const InputMemory memory_;
  const std::chrono::nanoseconds reshape_;
  const Invoke invoke_;
  std::vector<BatchLayout> input_layouts_, output_layouts_;
  std::vector<BlockPool> input_pools_;
  std::vector<size_t> output_offsets_, piece_offsets_;  // of each output within a block
  std::optional<BlockPool> output_pool_, piece_pool_;   // whole batches; frames cut out of them
  std::vector<weir_tensor> inputs_, outputs_, slices_;
  std::vector<std::shared_ptr<std::byte>> input_blocks_;  // the memory of inputs_
  std::shared_ptr<std::byte> output_block_;               // the memory of outputs_
  uint64_t copied_ = 0;                                   // bytes copied per frame into the batch
  BatchRun run_;
  std::optional<std::chrono::nanoseconds> full_invoke_;  // of the last full batch
};

}  // namespace weir::infer
