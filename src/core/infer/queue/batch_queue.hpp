// BatchQueue: decides which frames of several streams form the next batch, and when it is due. It
// has no thread, lock or clock: the caller passes the time.
//
// A batch is due when it is full; when its first frame has waited for the time-out of its stream;
// or when every active stream has contributed its share: batch-size divided by the number of these
// streams, at least one frame. A stream that a batch went without counts as inactive until it adds
// a frame again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/infer/queue/batch_job.hpp"

namespace weir::infer {

class BatchQueue {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using StreamId = uint64_t;

  explicit BatchQueue(size_t batch_size) : batch_size_(batch_size) {}  // >= 1

  StreamId join(std::chrono::nanoseconds timeout);
  // Returns the queued frames of the stream, oldest first. leave() also removes the stream.
  BatchJobs clear(StreamId stream);
  BatchJobs leave(StreamId stream);
  // The oldest queued frame of the stream; null if there is none.
  std::unique_ptr<BatchJob> take_oldest(StreamId stream);
  void add(StreamId stream, std::unique_ptr<BatchJob> job, Time now);
  // Marks the stream inactive until it adds a frame, for EOS and gaps.
  void pause(StreamId stream);
  // The same if no frame of it is queued, since further frames are held up by its own batches.
  void pause_if_empty(StreamId stream);

  bool due(Time now) const;
  // When the queued frames are due at the latest; nullopt: none queued.
  std::optional<Time> deadline() const;

  struct Taken {
    StreamId stream;
    std::unique_ptr<BatchJob> job;
  };
  // At most batch-size frames: the oldest of each stream, then the second of each and so on, in
  // order within each stream.
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
    bool expected = true;  // active
  };
  bool every_share_is_there() const;

  const size_t batch_size_;
  std::map<StreamId, Stream> streams_;
  size_t waiting_ = 0;  // queued frames of all streams
  uint64_t arrivals_ = 0;
  StreamId last_id_ = 0;
};

}  // namespace weir::infer
