// BatchGroup: a collector and its runner, for streams whose frames have the same shapes; and the
// groups of one model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/infer/batch/batch_collector.hpp"
#include "core/infer/batch/batch_runner.hpp"

namespace weir::infer {

class BatchGroup {
 public:
  BatchGroup(BatchShapes shapes, InputMemory memory, std::chrono::nanoseconds reshape,
             BatchRunner::Invoke invoke, BatchClock& clock = BatchClock::machine())
      : runner_(std::move(shapes), memory, reshape, std::move(invoke)),
        collector_(
            runner_.shapes().batch_size, [this](BatchJobs& jobs) { runner_.run(jobs); }, clock) {}

  const BatchShapes& shapes() const noexcept { return runner_.shapes(); }
  // The stream keeps the group alive.
  static std::unique_ptr<BatchCollector::Stream> join(const std::shared_ptr<BatchGroup>& group,
                                                      std::chrono::nanoseconds timeout) {
    return BatchCollector::join({group, &group->collector_}, timeout);
  }

 private:
  BatchRunner runner_;
  BatchCollector collector_;  // last: its thread uses the runner
};

// The groups of one model by batch-size and frame shapes. Thread-safe. A group is shared by its
// users and does not outlive them.
class BatchGroups {
 public:
  using Make = std::function<Result<std::shared_ptr<BatchGroup>>()>;
  // Returns the existing group or the result of `make`, for which concurrent callers wait.
  Result<std::shared_ptr<BatchGroup>> find(size_t batch_size,
                                           const std::vector<weir_tensor_info>& frame,
                                           const Make& make);

 private:
  std::mutex mutex_;  // guards groups_; held while a group is made
  std::map<std::string, std::weak_ptr<BatchGroup>> groups_;
};

}  // namespace weir::infer
