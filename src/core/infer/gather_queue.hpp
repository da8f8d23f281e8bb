// GatherQueue: which frames of several streams go into the next batch, and when it is due. No
// thread, no lock, no clock: who calls brings the time.
//
// A batch is due when it is full; when its first frame has waited for the time-out of its stream;
// or when every stream that can bring something has given its share: batch-size divided by the
// number of these streams, at least one frame. A stream that a batch went without is not waited for
// until it brings a frame again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/infer/batch_job.hpp"

namespace weir::infer {

class GatherQueue {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using StreamId = uint64_t;

  explicit GatherQueue(size_t batch_size) : batch_size_(batch_size) {}  // >= 1

  StreamId join(std::chrono::nanoseconds timeout);
  // The waiting frames of the stream, oldest first; the stream stays, or goes.
  BatchJobs clear(StreamId stream);
  BatchJobs leave(StreamId stream);
  // The oldest waiting frame of the stream; null when none waits.
  std::unique_ptr<BatchJob> take_oldest(StreamId stream);
  void add(StreamId stream, std::unique_ptr<BatchJob> job, Time now);
  // Until it adds a frame, the stream brings nothing: it ended, or has a gap.
  void pause(StreamId stream);
  // The same while no frame of it waits here: all that it may have on its way is behind.
  void pause_if_empty(StreamId stream);

  bool due(Time now) const;
  // When the waiting frames are due without more; nullopt: none waits.
  std::optional<Time> deadline() const;

  struct Taken {
    StreamId stream;
    std::unique_ptr<BatchJob> job;
  };
  // At most batch-size frames: the oldest of each stream, then the second of each, ...; each
  // stream's in order.
  std::vector<Taken> take();

  bool empty() const noexcept { return waiting_ == 0; }
  size_t streams() const noexcept { return streams_.size(); }

 private:
  struct Waiting {
    uint64_t arrival;
    Time deadline;
    std::unique_ptr<BatchJob> job;
  };
  struct Stream {
    std::chrono::nanoseconds timeout;
    std::deque<Waiting> frames;
    bool expected = true;  // is worth waiting for
  };
  bool every_share_is_there() const;

  const size_t batch_size_;
  std::map<StreamId, Stream> streams_;
  size_t waiting_ = 0;  // frames of all streams
  uint64_t arrivals_ = 0;
  StreamId last_id_ = 0;
};

}  // namespace weir::infer
