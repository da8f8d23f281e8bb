// WorkerPool: jobs on a fixed number of threads, bounded, with a policy for when all are busy.
//
//   WorkerPool<Frame> pool(limits, [](size_t worker, Frame frame) { ... });
//   auto room = pool.make_room(bytes);       // waits, or says what is dropped
//   if (room.granted) pool.put(frame, bytes);
//
// Jobs begin in the order in which they were put. One thread makes room and puts; the rest may be
// called from any thread. `Run` must not throw.
//
// Where several workers have all they can take, who waits for room works in the place of the first
// of them: a job each, that nobody is woken for. Its thread sleeps until one of the others finds
// jobs left over and the place empty.
#pragma once
#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/infer/busy_policy.hpp"
#include "core/infer/occupancy.hpp"

namespace weir::infer {

struct PoolState {
  size_t workers = 0, busy = 0, waiting = 0;
  double mean_busy = 0;     // since the first job
  uint64_t bytes_held = 0;  // of jobs that wait and that are in work
  uint64_t bytes_most = 0;  // the most that was held at a time
  bool holds_up = false;    // somebody waits for room
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
  // Waits for the jobs in work; those that wait are gone.
  ~WorkerPool() { stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  const PoolLimits& limits() const noexcept { return limits_; }

  struct Room {
    bool granted = false;      // false: the job that was to come is dropped, or the pool flushes
    std::vector<Job> dropped;  // jobs that waited
  };
  // Room for one job of `bytes`, which put() takes.
  Room make_room(uint64_t bytes) {
    std::unique_lock lock(mutex_);
    Room room;
    while (!flushing_) {
      const Verdict verdict = judge(limits_, load_, bytes);
      if (verdict == Verdict::DropNew) return room;
      if (verdict == Verdict::Take) {
        room.granted = true;
        return room;
      }
      if (verdict == Verdict::DropOldest)
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
      most_ = std::max(most_, load_.working_bytes + load_.waiting_bytes);
    }
    jobs_.notify_one();
  }

  // Gives back what waits and lets go who waits for room, until resume(). Jobs in work go on.
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

  // Waits until no job waits or is in work.
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
            most_,
            somebody_waits_};
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiting {
    Job job;
    uint64_t bytes;
  };
  static constexpr size_t kLent = 0;  // the worker whose place is lent

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
      else if (lent_ && !helping_ && waiting_.size() > 1)  // one is for this worker
        take_back();
      room_.notify_one();
    }
  }
  // For who makes room and found none.
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
  mutable std::mutex mutex_;  // guards the rest but threads_; never held while a job runs
  std::condition_variable jobs_, room_, idle_, lent_back_;
  std::deque<Waiting> waiting_;
  PoolLoad load_;
  Occupancy occupancy_;
  uint64_t most_ = 0;
  bool flushing_ = false, stopping_ = false;
  // The place of the first worker: whether who makes room may work there, does so, waits for it.
  bool lent_ = false, helping_ = false, somebody_waits_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace weir::infer
