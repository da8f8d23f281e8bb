// BatchGatherer: frames of several streams, handed in from their threads, leave as batches on one
// thread.
//
//   auto gatherer = std::make_shared<BatchGatherer>(4, [](BatchJobs& jobs) { ... });
//   auto stream = BatchGatherer::join(gatherer, 10ms);
//   stream->add(std::move(job));
//
// The thread lives as long as the gatherer. When a batch goes: gather_queue.hpp.
#pragma once
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "core/infer/batch_clock.hpp"
#include "core/infer/gather_queue.hpp"

namespace weir::infer {

class BatchGatherer {
 public:
  // Runs one batch on the gatherer's thread and ends each of its jobs. One call at a time.
  using Run = std::function<void(BatchJobs& jobs)>;

  // batch_size >= 1; `clock` is borrowed.
  BatchGatherer(size_t batch_size, Run run, BatchClock& clock = BatchClock::machine());
  ~BatchGatherer();
  BatchGatherer(const BatchGatherer&) = delete;
  BatchGatherer& operator=(const BatchGatherer&) = delete;

  // One stream's place. Every function may be called from any thread, but never from a job.
  class Stream {
   public:
    // Waits until no job of this stream is in the batch that runs; those that wait are freed.
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    void add(std::unique_ptr<BatchJob> job);
    // Takes back what no batch has begun, oldest first. The batch that runs ends its jobs later.
    BatchJobs flush();
    // The same of the oldest one alone; null when none waits.
    std::unique_ptr<BatchJob> take_oldest();
    // Until the next add(), batches do not wait for this stream: it ended, or has a gap.
    void pause();
    // The same when no frame of it waits: what it may have on its way is held up behind its
    // batches.
    void pause_if_empty();

   private:
    friend class BatchGatherer;
    Stream(std::shared_ptr<BatchGatherer> gatherer, GatherQueue::StreamId id)
        : gatherer_(std::move(gatherer)), id_(id) {}
    std::shared_ptr<BatchGatherer> gatherer_;
    GatherQueue::StreamId id_;
  };
  // `timeout`: how long a frame of this stream waits for others at most; >= 0.
  static std::unique_ptr<Stream> join(std::shared_ptr<BatchGatherer> gatherer,
                                      std::chrono::nanoseconds timeout);

  // Runs `change` between two batches, on the calling thread: nothing is being run meanwhile.
  void between_batches(const std::function<void()>& change);
  size_t streams() const;

 private:
  void gather();
  bool runs(GatherQueue::StreamId stream) const;

  const Run run_;
  BatchClock& clock_;
  mutable std::mutex mutex_;         // guards all below
  std::condition_variable changed_;  // frames, streams, ending
  std::condition_variable ended_;    // a batch
  GatherQueue queue_;
  std::vector<GatherQueue::StreamId> running_;  // of the batch that runs, one for each job
  size_t held_ = 0;                             // between_batches() that wait or go on
  bool busy_ = false, stopping_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace weir::infer
