// BatchCollector: collects frames from the threads of several streams into batches that run on one
// thread.
//
//   auto collector = std::make_shared<BatchCollector>(4, [](BatchJobs& jobs) { ... });
//   auto stream = BatchCollector::join(collector, 10ms);
//   stream->add(std::move(job));
//
// The thread lives as long as the collector. batch_queue.hpp defines when a batch is due.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "core/infer/queue/batch_queue.hpp"

namespace weir::infer {

class BatchClock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  virtual ~BatchClock() = default;
  virtual Time now() = 0;
  // Waits for `changed` (locked with `lock`) until `until`; may return early.
  virtual void wait_until(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                          Time until) = 0;
  // The steady clock.
  static BatchClock& machine();
};

class BatchCollector {
 public:
  // Runs one batch on the collector's thread and ends each of its jobs. Calls do not overlap.
  using Run = std::function<void(BatchJobs& jobs)>;

  // batch_size >= 1; `clock` is borrowed.
  BatchCollector(size_t batch_size, Run run, BatchClock& clock = BatchClock::machine());
  ~BatchCollector();
  BatchCollector(const BatchCollector&) = delete;
  BatchCollector& operator=(const BatchCollector&) = delete;

  // The input of one stream. Call the functions from any thread, but never from a job.
  class Stream {
   public:
    // Waits until the running batch has no job of this stream; frees queued jobs.
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    void add(std::unique_ptr<BatchJob> job);
    // Takes back queued jobs, oldest first. The running batch ends its own jobs later.
    BatchJobs flush();
    // Takes back the oldest queued job only; null if there is none.
    std::unique_ptr<BatchJob> take_oldest();
    // Excludes this stream from the wait for a full batch until the next add(), for EOS and gaps.
    void pause();
    // pause(), unless a frame of this stream is queued. Call it when further frames may be held up
    // by the stream's own batches.
    void pause_if_empty();

   private:
    friend class BatchCollector;
    Stream(std::shared_ptr<BatchCollector> collector, BatchQueue::StreamId id)
        : collector_(std::move(collector)), id_(id) {}
    std::shared_ptr<BatchCollector> collector_;
    BatchQueue::StreamId id_;
  };
  // `timeout` (>= 0) limits how long a frame of this stream waits for others.
  static std::unique_ptr<Stream> join(std::shared_ptr<BatchCollector> collector,
                                      std::chrono::nanoseconds timeout);

  // Runs `change` on the calling thread while no batch is running.
  void between_batches(const std::function<void()>& change);
  size_t streams() const;

 private:
  void gather();
  bool runs(BatchQueue::StreamId stream) const;

  const Run run_;
  BatchClock& clock_;
  mutable std::mutex mutex_;         // guards all below
  std::condition_variable changed_;  // frames, streams or stopping_
  std::condition_variable ended_;    // a batch has ended
  BatchQueue queue_;
  std::vector<BatchQueue::StreamId> running_;  // of the running batch, one per job
  size_t held_ = 0;                            // between_batches() calls that wait or run
  bool busy_ = false, stopping_ = false;
  std::thread thread_;  // last: uses the other members
};

}  // namespace weir::infer
