// Tests order, limits, drops, flushes and destruction with jobs that the test blocks and releases.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/worker_pool.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "becomes.hpp"

namespace weir::infer {
namespace worker_pool_test {

// Blocks jobs until the test releases them.
class Gate {
 public:
  void enter(int job) {
    std::unique_lock lock(mutex_);
    entered_.push_back(job);
    changed_.notify_all();
    changed_.wait(lock, [&] { return open_ || passes_ > 0; });
    if (!open_) --passes_;
    left_.push_back(job);
    changed_.notify_all();
  }
  void wait_for_entered(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return entered_.size() >= count; });
  }
  void wait_for_left(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return left_.size() >= count; });
  }
  void let_one_go() {
    std::lock_guard lock(mutex_);
    ++passes_;
    changed_.notify_all();
  }
  void open() {
    std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  std::vector<int> entered() {
    std::lock_guard lock(mutex_);
    return entered_;
  }

 private:
  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::vector<int> entered_, left_;
  int passes_ = 0;
  bool open_ = false;
};

using Pool = WorkerPool<int>;

struct Gated {
  explicit Gated(const PoolLimits& limits)
      : pool(limits, [this](size_t, int n) { gate.enter(n); }) {}
  ~Gated() { gate.open(); }
  // The dropped jobs, including the new job if it was dropped.
  std::vector<int> offer(int job, uint64_t bytes = 1) {
    auto room = pool.make_room(bytes);
    if (room.granted)
      pool.put(job, bytes);
    else
      room.dropped.push_back(job);
    return room.dropped;
  }
  Gate gate;
  Pool pool;
};
using Numbers = std::vector<int>;

TEST(WorkerPool, RunsAsManyJobsAtOnceAsItHasWorkers) {
  Gated g({3, WhenBusy::Block});
  for (int i = 0; i < 3; ++i) g.offer(i);
  g.gate.wait_for_entered(3);
  const auto state = g.pool.state();
  EXPECT_EQ(state.workers, 3u);
  EXPECT_EQ(state.busy, 3u);
  EXPECT_EQ(state.waiting, 0u);
  EXPECT_GT(state.mean_busy, 0);
}

TEST(WorkerPool, PassesEachJobItsWorker) {
  std::atomic<unsigned> seen{0};
  {
    Pool pool({4, WhenBusy::Block}, [&](size_t worker, int) { seen |= 1u << worker; });
    for (int i = 0; i < 1000; ++i) {
      pool.make_room(1);
      pool.put(i, 1);
    }
    pool.wait_until_idle();
  }
  EXPECT_NE(seen, 0u);
  EXPECT_LT(seen, 1u << 4);
}

TEST(WorkerPool, StartsJobsInTheOrderOfSubmission) {
  Gated g({1, WhenBusy::Block});
  g.gate.open();
  Numbers expected;
  for (int i = 0; i < 500; ++i) {
    EXPECT_TRUE(g.offer(i).empty());
    expected.push_back(i);
  }
  g.gate.wait_for_left(500);
  EXPECT_EQ(g.gate.entered(), expected);
}

TEST(WorkerPool, BlocksWhenEachWorkerHasAnotherJobReady) {
  Gated g({2, WhenBusy::Block});
  for (int i = 0; i < 4; ++i) g.offer(i);
  std::atomic<bool> taken{false};
  std::thread other([&] {
    g.offer(4);
    taken = true;
  });
  g.gate.wait_for_entered(2);
  EXPECT_EQ(g.pool.state().waiting, 2u);
  EXPECT_FALSE(taken);
  g.gate.let_one_go();
  other.join();
  EXPECT_TRUE(taken);
}

TEST(WorkerPool, DropsTheNewWhenItIsBusy) {
  Gated g({1, WhenBusy::DropNew});
  EXPECT_EQ(g.offer(0), Numbers{});
  EXPECT_EQ(g.offer(1), Numbers{1});
  EXPECT_EQ(g.offer(2), Numbers{2});
  g.gate.wait_for_entered(1);
  g.gate.let_one_go();
  g.pool.wait_until_idle();
  EXPECT_EQ(g.offer(3), Numbers{});
  g.gate.wait_for_entered(2);
  EXPECT_EQ(g.gate.entered(), (Numbers{0, 3}));
}

TEST(WorkerPool, KeepsTheNewestWhereTheOldIsDropped) {
  Gated g({1, WhenBusy::DropOld});
  g.offer(0);
  g.gate.wait_for_entered(1);
  EXPECT_EQ(g.offer(1), Numbers{});
  EXPECT_EQ(g.offer(2), Numbers{1});
  EXPECT_EQ(g.offer(3), Numbers{2});
  g.gate.let_one_go();
  g.gate.wait_for_entered(2);
  EXPECT_EQ(g.gate.entered(), (Numbers{0, 3}));
}

TEST(WorkerPool, CountsTheBytesOfWaitingAndRunningJobs) {
  Gated g({1, WhenBusy::DropNew, 0});
  g.offer(0, 70);
  g.gate.wait_for_entered(1);
  EXPECT_EQ(g.pool.state().bytes_held, 70u);
  g.gate.let_one_go();
  g.pool.wait_until_idle();
  EXPECT_EQ(g.pool.state().bytes_peak, 70u);
}

TEST(WorkerPool, WaitsForBytesThatAreHeld) {
  Gated g({2, WhenBusy::Block, 100});
  g.offer(0, 60);
  std::atomic<bool> taken{false};
  std::thread other([&] {
    g.offer(1, 60);
    taken = true;
  });
  g.gate.wait_for_entered(1);
  EXPECT_FALSE(taken);
  g.gate.let_one_go();
  other.join();
  g.gate.wait_for_entered(2);
  EXPECT_EQ(g.pool.state().bytes_peak, 60u);
}

TEST(WorkerPool, AFlushReturnsWaitingJobs) {
  Gated g({1, WhenBusy::Block});
  g.offer(0);
  g.gate.wait_for_entered(1);
  g.offer(1);
  EXPECT_EQ(g.pool.flush(), Numbers{1});
  EXPECT_EQ(g.offer(2), Numbers{2}) << "nothing is taken";
  EXPECT_EQ(g.pool.state().busy, 1u) << "what is in work goes on";
  g.pool.resume();
  EXPECT_EQ(g.offer(3), Numbers{});
}

TEST(WorkerPool, AFlushWakesWaitingCallers) {
  Gated g({1, WhenBusy::Block});
  g.offer(0);
  g.gate.wait_for_entered(1);
  g.offer(1);
  std::thread other([&] { EXPECT_EQ(g.offer(2), Numbers{2}); });
  EXPECT_EQ(g.pool.flush(), Numbers{1});
  other.join();
}

TEST(WorkerPool, WaitsUntilAllJobsAreDone) {
  Gated g({1, WhenBusy::Block});
  g.pool.wait_until_idle();
  g.offer(0);
  g.offer(1);
  g.gate.wait_for_entered(1);
  std::thread other([&] { g.gate.open(); });
  g.pool.wait_until_idle();
  EXPECT_EQ(g.gate.entered(), (Numbers{0, 1}));
  EXPECT_EQ(g.pool.state().busy, 0u);
  other.join();
}

TEST(WorkerPool, CanBeDestroyedWithRunningAndWaitingJobs) {
  Gate gate;
  std::optional<Pool> pool;
  pool.emplace(PoolLimits{1, WhenBusy::Block}, [&](size_t, int n) { gate.enter(n); });
  for (int i = 0; i < 2; ++i) {
    pool->make_room(1);
    pool->put(i, 1);
  }
  gate.wait_for_entered(1);
  std::thread other([&] { gate.open(); });
  pool.reset();
  other.join();
  EXPECT_EQ(gate.entered().front(), 0);
}

// Blocks jobs per worker; records which worker ran which job on which thread.
class Places {
 public:
  struct Run {
    int job;
    size_t worker;
    std::thread::id thread;
  };
  void enter(size_t worker, int job) {
    std::unique_lock lock(mutex_);
    runs_.push_back({job, worker, std::this_thread::get_id()});
    ++in_work_[worker];
    max_ = std::max(max_, in_work_[worker]);
    changed_.notify_all();
    changed_.wait(lock, [&] { return open_ || turns_[worker] > 0; });
    if (!open_) --turns_[worker];
    --in_work_[worker];
  }
  void let_go(size_t worker) {
    std::lock_guard lock(mutex_);
    ++turns_[worker];
    changed_.notify_all();
  }
  void open() {
    std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  Run wait_for(int job) {
    std::unique_lock lock(mutex_);
    const auto is_it = [&](const Run& run) { return run.job == job; };
    changed_.wait(lock, [&] { return std::any_of(runs_.begin(), runs_.end(), is_it); });
    return *std::find_if(runs_.begin(), runs_.end(), is_it);
  }
  std::vector<Run> runs() {
    std::lock_guard lock(mutex_);
    return runs_;
  }
  int max_in_a_place() {
    std::lock_guard lock(mutex_);
    return max_;
  }

 private:
  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::vector<Run> runs_;
  int turns_[2] = {}, in_work_[2] = {}, max_ = 0;
  bool open_ = false;
};

// Jobs 0 and 1 run, 2 and 3 are queued, and a thread that adds 4 and 5 is blocked by 4.
struct HeldUp {
  HeldUp()
      : pool({2, WhenBusy::Block}, [this](size_t worker, int job) { places.enter(worker, job); }) {
    for (int i = 0; i < 4; ++i) put(i);
    places.wait_for(0);
    places.wait_for(1);
    bringer = std::thread([this] { put(4), put(5); });
    id = bringer.get_id();
    EXPECT_TRUE(becomes_true([&] { return pool.state().holds_up; }, "a held up bringer"));
  }
  ~HeldUp() {
    places.open();
    if (bringer.joinable()) bringer.join();
  }
  void put(int job) {
    if (pool.make_room(1).granted) pool.put(job, 1);
  }
  Places places;
  Pool pool;
  std::thread bringer;
  std::thread::id id;
};

TEST(WorkerPool, LendsASlotToABlockedCaller) {
  HeldUp h;
  h.places.let_go(0);
  const auto third = h.places.wait_for(2);
  EXPECT_EQ(third.thread, h.id);
  EXPECT_EQ(third.worker, 0u);
  EXPECT_EQ(h.pool.state().busy, 2u);
  h.places.open();
  h.bringer.join();
  h.pool.wait_until_idle();
  EXPECT_EQ(h.places.max_in_a_place(), 1) << "a session is used by one thread at a time";
  EXPECT_EQ(h.places.runs().size(), 6u);
}

TEST(WorkerPool, TakesTheSlotBackWhenItsOwnerIsGone) {
  HeldUp h;
  h.places.let_go(0);
  h.places.wait_for(2);
  h.places.let_go(0);  // the producer's, which then returns
  h.bringer.join();
  EXPECT_EQ(h.pool.state().busy, 1u);
  h.places.let_go(1);
  const auto fourth = h.places.wait_for(3), fifth = h.places.wait_for(4);
  EXPECT_EQ(fourth.worker + fifth.worker, 1u) << "both places are at work";
  EXPECT_NE(fourth.thread, h.id);
  EXPECT_NE(fifth.thread, h.id);
}

TEST(WorkerPool, AFlushReleasesTheSlotOfACaller) {
  HeldUp h;
  h.places.let_go(0);
  h.places.wait_for(2);
  EXPECT_EQ(h.pool.flush(), (Numbers{3, 4}));
  h.places.let_go(0);
  h.bringer.join();
  EXPECT_EQ(h.pool.state().waiting, 0u) << "job 5 was refused";
  h.pool.resume();
  h.put(6);  // worker 1 has its job; the lent place is unused
  h.places.let_go(1);
  h.places.wait_for(6);
}

TEST(WorkerPool, LendsNoSlotOfASingleWorker) {
  Places places;
  Pool pool({1, WhenBusy::Block}, [&](size_t worker, int job) { places.enter(worker, job); });
  for (int i = 0; i < 2; ++i)
    if (pool.make_room(1).granted) pool.put(i, 1);
  std::thread bringer([&] {
    for (const int job : {2, 3})
      if (pool.make_room(1).granted) pool.put(job, 1);
  });
  EXPECT_TRUE(becomes_true([&] { return pool.state().holds_up; }, "a held up bringer"));
  places.let_go(0);
  EXPECT_EQ(places.wait_for(1).thread, places.wait_for(0).thread);
  places.open();
  bringer.join();
  pool.wait_until_idle();
  for (const auto& run : places.runs()) EXPECT_EQ(run.thread, places.wait_for(0).thread);
}

// One thread adds jobs, another flushes at random: each job is run, dropped or returned once.
TEST(WorkerPool, LosesNoJobUnderThreads) {
  for (const auto when_busy : {WhenBusy::Block, WhenBusy::DropNew, WhenBusy::DropOld}) {
    constexpr size_t kCount = 3000;
    std::vector<std::atomic<int>> seen(kCount);
    Pool pool({3, when_busy, 50}, [&](size_t, int n) { ++seen[static_cast<size_t>(n)]; });
    std::atomic<bool> done{false};
    std::thread flusher([&] {
      while (!done) {
        for (const int n : pool.flush()) ++seen[static_cast<size_t>(n)];
        pool.resume();
        std::this_thread::yield();
      }
    });
    for (size_t i = 0; i < kCount; ++i) {
      const uint64_t bytes = 1 + i % 60;
      auto room = pool.make_room(bytes);
      for (const int n : room.dropped) ++seen[static_cast<size_t>(n)];
      if (room.granted)
        pool.put(static_cast<int>(i), bytes);
      else
        ++seen[i];
    }
    done = true;
    flusher.join();
    pool.wait_until_idle();
    for (size_t i = 0; i < kCount; ++i) EXPECT_EQ(seen[i], 1) << i;
    EXPECT_LE(pool.state().bytes_peak, 60u);
  }
}

}  // namespace worker_pool_test
}  // namespace weir::infer
