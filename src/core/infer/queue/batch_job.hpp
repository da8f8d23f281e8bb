// BatchJob: one frame of one stream in a batch.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/infer/queue/invoke_end.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// Describes a batch that was run.
struct BatchRun {
  uint64_t number = 0;  // counts the batches of one collector from 1
  size_t frames = 0;    // of all streams
  std::chrono::nanoseconds invoke{};
  InvokeEnd end{};
};

// The collector calls exactly one of done, failed and dropped, once, on its thread, unless
// end_if_useless() has ended the job; none of them may block or throw. A job returned before its
// batch began is not ended.
class BatchJob {
 public:
  virtual ~BatchJob() = default;
  // The frame's tensors, in the order of the model's inputs; readable until the job is ended.
  virtual std::span<const weir_tensor> inputs() const = 0;
  // When its result becomes useless, by CLOCK_MONOTONIC in nanoseconds; 0 = never.
  virtual int64_t expires() const { return 0; }
  // Called before the batch runs. True: its result would be useless, and the job has ended.
  virtual bool end_if_useless() { return false; }
  // `owner` keeps the memory of `outputs` alive; `copied`: bytes copied for this frame.
  virtual void done(const BatchRun& run, std::span<const weir_tensor> outputs,
                    const std::shared_ptr<void>& owner, uint64_t copied) = 0;
  virtual void failed(const Error& error) = 0;
  virtual void dropped(const BatchRun& run) = 0;  // the engine drops the batch
};

using BatchJobs = std::vector<std::unique_ptr<BatchJob>>;

}  // namespace weir::infer
