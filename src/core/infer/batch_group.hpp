// BatchGroup: a gatherer and what it runs, for streams whose frames have the same shapes; and the
// groups of one model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/infer/batch_gatherer.hpp"
#include "core/infer/batch_runner.hpp"

namespace weir::infer {

class BatchGroup {
 public:
  BatchGroup(BatchShapes shapes, InputMemory memory, std::chrono::nanoseconds reshape,
             BatchRunner::Invoke invoke, BatchClock& clock = BatchClock::machine())
      : runner_(std::move(shapes), memory, reshape, std::move(invoke)),
        gatherer_(
            runner_.shapes().batch_size, [this](BatchJobs& jobs) { runner_.run(jobs); }, clock) {}

  const BatchShapes& shapes() const noexcept { return runner_.shapes(); }
  // A stream keeps its group.
  static std::unique_ptr<BatchGatherer::Stream> join(const std::shared_ptr<BatchGroup>& group,
                                                     std::chrono::nanoseconds timeout) {
    return BatchGatherer::join({group, &group->gatherer_}, timeout);
  }

 private:
  BatchRunner runner_;
  BatchGatherer gatherer_;  // last: its thread uses the runner
};

// The groups of one model, found by batch-size and the shapes of a frame. Thread-safe. A group
// lives as long as somebody holds it.
class BatchGroups {
 public:
  using Make = std::function<Result<std::shared_ptr<BatchGroup>>()>;
  // The group that is there, or the one that `make` makes; others who ask wait for it.
  Result<std::shared_ptr<BatchGroup>> find(size_t batch_size,
                                           const std::vector<weir_tensor_info>& frame,
                                           const Make& make);

 private:
  std::mutex mutex_;  // guards groups_; held while a group is made
  std::map<std::string, std::weak_ptr<BatchGroup>> groups_;
};

}  // namespace weir::infer
