// WorkerPool: runs jobs on a fixed number of threads, with a limit and a policy for when all are
// busy.
//
//   WorkerPool<Frame> pool(limits, [](size_t worker, Frame frame) { ... });
//   auto room = pool.make_room(bytes);       // waits, or returns the jobs to drop
//   if (room.granted) pool.put(frame, bytes);
//
// Jobs begin in the order of put(). One thread calls make_room() and put(); the other functions are
// thread-safe. `Run` must not throw.
//
// With several workers that are all fully loaded, the thread that waits for room takes the place of
// the first worker and runs a job at a time, which saves waking a thread. The worker's own thread
// sleeps until another worker finds queued jobs and the place unused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/infer/queue/busy_policy.hpp"
#include "core/infer/queue/occupancy.hpp"

namespace weir::infer {

struct PoolState {
  size_t workers = 0, busy = 0, waiting = 0;
  double mean_busy = 0;     // since the first job
  uint64_t bytes_held = 0;  // of queued and running jobs
  uint64_t bytes_peak = 0;  // the peak of bytes_held
  bool holds_up = false;    // a caller waits for room
};

template <class Job>
class WorkerPool {
 public:
  using Run = std::function<void(size_t worker, Job job)>;  // `worker` < limits.workers

  WorkerPool(const PoolLimits& limits, Run run) : limits_(limits), run_(std::move(run)) {
    threads_.reserve(limits.workers);
    try {
      for (size_t i = 0; i < limits.workers; ++i) threads_.emplace_back([this, i] { work(i); });
    } catch (...) {
      stop();
      throw;
    }
  }
  // Waits for running jobs; queued jobs are destroyed.
  ~WorkerPool() { stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  const PoolLimits& limits() const noexcept { return limits_; }

  struct Room {
    bool granted = false;      // false: drop the new job, or the pool flushes
    std::vector<Job> dropped;  // queued jobs
  };
  // Makes room for one job of `bytes`, to be passed to put().
  Room make_room(uint64_t bytes) {
    std::unique_lock lock(mutex_);
    Room room;
    while (!flushing_) {
      const BusyDecision verdict = judge(limits_, load_, bytes);
      if (verdict == BusyDecision::DropNew) return room;
      if (verdict == BusyDecision::Take) {
        room.granted = true;
        return room;
      }
      if (verdict == BusyDecision::DropOldest)
        room.dropped.push_back(take_oldest().job);
      else
        work_or_wait(lock);
    }
    return room;
  }
  void put(Job job, uint64_t bytes) {
    {
      std::lock_guard lock(mutex_);
      waiting_.push_back({std::move(job), bytes});
      ++load_.waiting;
      load_.waiting_bytes += bytes;
      peak_ = std::max(peak_, load_.working_bytes + load_.waiting_bytes);
    }
    jobs_.notify_one();
  }

  // Returns the queued jobs and wakes callers that wait for room, until resume(). Running jobs
  // continue.
  std::vector<Job> flush() {
    std::lock_guard lock(mutex_);
    flushing_ = true;
    std::vector<Job> out;
    while (!waiting_.empty()) out.push_back(take_oldest().job);
    room_.notify_all();
    idle_.notify_all();
    return out;
  }
  void resume() {
    std::lock_guard lock(mutex_);
    flushing_ = false;
  }

  // Waits until no job is queued or running.
  void wait_until_idle() {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return load_.waiting == 0 && load_.working == 0; });
  }

  PoolState state() const {
    std::lock_guard lock(mutex_);
    return {limits_.workers,
            occupancy_.busy(),
            load_.waiting,
            occupancy_.mean(Clock::now()),
            load_.working_bytes + load_.waiting_bytes,
            peak_,
            somebody_waits_};
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiting {
    Job job;
    uint64_t bytes;
  };
  static constexpr size_t kLent = 0;  // the worker whose place can be lent

  Waiting take_oldest() {
    Waiting taken = std::move(waiting_.front());
    waiting_.pop_front();
    --load_.waiting;
    load_.waiting_bytes -= taken.bytes;
    return taken;
  }
  void work(size_t worker) {
    std::unique_lock lock(mutex_);
    for (;;) {
      if (worker == kLent) lent_back_.wait(lock, [this] { return stopping_ || !lent_; });
      jobs_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
      if (stopping_) return;
      run_oldest(lock, worker);
      if (worker == kLent)
        lent_ = somebody_waits_ && limits_.workers > 1;
      else if (lent_ && !helping_ && waiting_.size() > 1)  // this worker takes one of them
        take_back();
      room_.notify_one();
    }
  }
  // For make_room() without room.
  void work_or_wait(std::unique_lock<std::mutex>& lock) {
    if (lent_ && !waiting_.empty()) {
      helping_ = true;
      run_oldest(lock, kLent);
      helping_ = false;
      return;
    }
    somebody_waits_ = true;
    room_.wait(lock);
    somebody_waits_ = false;
  }
  void take_back() {
    lent_ = false;
    lent_back_.notify_one();
  }
  void run_oldest(std::unique_lock<std::mutex>& lock, size_t worker) {
    Waiting taken = take_oldest();
    ++load_.working;
    load_.working_bytes += taken.bytes;
    occupancy_.begin(Clock::now());
    lock.unlock();
    run_(worker, std::move(taken.job));
    lock.lock();
    occupancy_.end(Clock::now());
    --load_.working;
    load_.working_bytes -= taken.bytes;
    if (load_.working == 0 && waiting_.empty()) idle_.notify_all();
  }
  void stop() {
    std::deque<Waiting> gone;
    {
      std::lock_guard lock(mutex_);
      stopping_ = true;
      gone.swap(waiting_);
      jobs_.notify_all();
      lent_back_.notify_all();
    }
    for (auto& thread : threads_) thread.join();
  }

  const PoolLimits limits_;
  const Run run_;
  mutable std::mutex mutex_;  // guards the rest except threads_; never held while a job runs
  std::condition_variable jobs_, room_, idle_, lent_back_;
  std::deque<Waiting> waiting_;
  PoolLoad load_;
  Occupancy occupancy_;
  uint64_t peak_ = 0;
  bool flushing_ = false, stopping_ = false;
  // The place of the first worker: lent to the caller of make_room(), in use by it; that caller
  // waits.
  bool lent_ = false, helping_ = false, somebody_waits_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::infer
