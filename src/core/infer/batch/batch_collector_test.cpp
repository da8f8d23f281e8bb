// Multithreaded tests of the collector: waiting, and that each frame returns once, in order, to its
// own stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_collector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <random>

#include "core/infer/queue/numbered_job_test_support.hpp"

namespace weir::infer {
namespace batch_collector_test {

using namespace std::chrono_literals;

// A clock that only the test advances.
class SetClock final : public BatchClock {
 public:
  Time now() override {
    std::lock_guard lock(mutex_);
    return now_;
  }
  void wait_until(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                  Time until) override {
    {
      std::lock_guard own(mutex_);
      if (until <= now_) return;
      waiting_on_ = &changed;
      waiting_with_ = lock.mutex();
      waiting_until_ = until;
      requested_.notify_all();
    }
    changed.wait(lock);
    std::lock_guard own(mutex_);
    waiting_on_ = nullptr;
  }
  void advance(std::chrono::nanoseconds by) {
    std::condition_variable* waiting = nullptr;
    std::mutex* with = nullptr;
    {
      std::lock_guard lock(mutex_);
      now_ += by;
      waiting = waiting_on_;
      with = waiting_with_;
    }
    if (!waiting) return;
    const std::lock_guard lock(*with);  // the thread waits, or has not read the time yet
    waiting->notify_all();
  }
  // Returns when a thread waits for `until` after the start.
  void wait_for_waiter(std::chrono::nanoseconds until) {
    std::unique_lock lock(mutex_);
    requested_.wait(lock, [&] { return waiting_on_ && waiting_until_ == Time{} + until; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable requested_;
  Time now_{}, waiting_until_{};
  std::condition_variable* waiting_on_ = nullptr;
  std::mutex* waiting_with_ = nullptr;
};

// Records the batches and ends every job as done.
class Batches {
 public:
  BatchCollector::Run run() {
    return [this](BatchJobs& jobs) {
      std::unique_lock lock(mutex_);
      std::vector<Numbered> batch;
      for (const auto& job : jobs) batch.push_back(number_of(*job));
      begun_.push_back(batch);
      changed_.notify_all();
      changed_.wait(lock, [this] { return !held_; });
      lock.unlock();
      for (auto& job : jobs) job->done({1, jobs.size(), 0ns}, {}, nullptr, 0);
    };
  }
  std::vector<Numbered> batch(size_t index) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return begun_.size() > index; });
    return begun_[index];
  }
  size_t count() {
    std::lock_guard lock(mutex_);
    return begun_.size();
  }
  void hold(bool held) {
    std::lock_guard lock(mutex_);
    held_ = held;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::vector<Numbered>> begun_;
  bool held_ = false;
};

struct Ended {
  NumberedJob::Ended note() {
    return [this](const NumberedJob::End& end) {
      std::lock_guard lock(mutex);
      jobs.push_back(end.job);
    };
  }
  std::vector<Numbered> all() {
    std::lock_guard lock(mutex);
    return jobs;
  }
  std::mutex mutex;
  std::vector<Numbered> jobs;
};

TEST(BatchCollector, AFullBatchRunsAtOnce) {
  SetClock clock;
  Batches batches;
  const auto collector = std::make_shared<BatchCollector>(2, batches.run(), clock);
  const auto a = BatchCollector::join(collector, 1h), b = BatchCollector::join(collector, 1h);
  a->add(numbered(1, 1));
  b->add(numbered(2, 1));
  EXPECT_EQ(batches.batch(0), (std::vector<Numbered>{{1, 1}, {2, 1}}));
}

TEST(BatchCollector, APartialBatchRunsAtItsTimeout) {
  SetClock clock;
  Batches batches;
  const auto collector = std::make_shared<BatchCollector>(3, batches.run(), clock);
  const auto a = BatchCollector::join(collector, 10ms),
             dead = BatchCollector::join(collector, 10ms);
  a->add(numbered(1, 1));
  clock.wait_for_waiter(10ms);
  clock.advance(9ms);
  EXPECT_EQ(batches.count(), 0u);
  clock.advance(1ms);
  EXPECT_EQ(batches.batch(0), (std::vector<Numbered>{{1, 1}}));
}

TEST(BatchCollector, AnEarlierDeadlineOfAnotherStreamCounts) {
  SetClock clock;
  Batches batches;
  const auto collector = std::make_shared<BatchCollector>(9, batches.run(), clock);
  const auto patient = BatchCollector::join(collector, 1h);
  const auto hasty = BatchCollector::join(collector, 5ms);
  patient->add(numbered(1, 1));
  clock.wait_for_waiter(1h);
  hasty->add(numbered(2, 1));
  clock.wait_for_waiter(5ms);
  clock.advance(5ms);
  EXPECT_EQ(batches.batch(0), (std::vector<Numbered>{{1, 1}, {2, 1}}));
}

TEST(BatchCollector, AStreamThatLeavesOrPausesDoesNotBlockTheOthers) {
  SetClock clock;
  Batches batches;
  const auto collector = std::make_shared<BatchCollector>(2, batches.run(), clock);
  const auto a = BatchCollector::join(collector, 1h);
  auto b = BatchCollector::join(collector, 1h), c = BatchCollector::join(collector, 1h);
  EXPECT_EQ(collector->streams(), 3u);
  a->add(numbered(1, 1));
  b->pause();
  c.reset();
  EXPECT_EQ(collector->streams(), 2u);
  a->pause();
  EXPECT_EQ(batches.batch(0), (std::vector<Numbered>{{1, 1}}));
}

TEST(BatchCollector, FramesThatArriveDuringABatchJoinTheNextOne) {
  SetClock clock;
  Batches batches;
  const auto collector = std::make_shared<BatchCollector>(2, batches.run(), clock);
  const auto a = BatchCollector::join(collector, 1h), b = BatchCollector::join(collector, 1h);
  batches.hold(true);
  a->add(numbered(1, 1));
  b->add(numbered(2, 1));
  batches.batch(0);
  for (int i = 2; i <= 4; ++i) a->add(numbered(1, i));
  b->add(numbered(2, 2));
  batches.hold(false);
  EXPECT_EQ(batches.batch(1), (std::vector<Numbered>{{1, 2}, {2, 2}}));
  EXPECT_EQ(batches.batch(2), (std::vector<Numbered>{{1, 3}, {1, 4}}));
}

TEST(BatchCollector, AFlushRemovesFramesThatAreInNoBatch) {
  SetClock clock;
  Batches batches;
  Ended ended;
  const auto collector = std::make_shared<BatchCollector>(2, batches.run(), clock);
  auto a = BatchCollector::join(collector, 1h);
  const auto b = BatchCollector::join(collector, 1h);
  batches.hold(true);
  a->add(numbered(1, 1, ended.note()));
  b->add(numbered(2, 1, ended.note()));
  batches.batch(0);
  a->add(numbered(1, 2, ended.note()));
  const auto back = a->flush();
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(number_of(*back[0]), (Numbered{1, 2}));
  a->add(numbered(1, 3, ended.note()));
  batches.hold(false);
  a.reset();  // waits for its frame in the batch, frees queued ones
  const auto jobs = ended.all();
  EXPECT_EQ(std::count(jobs.begin(), jobs.end(), Numbered{1, 1}), 1);
  EXPECT_EQ(std::count(jobs.begin(), jobs.end(), Numbered{1, 2}), 0);
}

TEST(BatchCollector, ChangesApplyBetweenBatches) {
  Batches batches;
  std::atomic<bool> running = false, changing = false;
  std::atomic<int> together = 0, ended = 0;
  const auto collector = std::make_shared<BatchCollector>(2, [&](BatchJobs& jobs) {
    running = true;
    if (changing) ++together;
    for (auto& job : jobs) job->dropped({});
    running = false;
    ended += static_cast<int>(jobs.size());
    ended.notify_all();
  });
  const auto a = BatchCollector::join(collector, 0ns);
  for (int i = 0; i < 200; ++i) {
    a->add(numbered(1, i));
    collector->between_batches([&] {
      changing = true;
      if (running) ++together;
      changing = false;
    });
  }
  for (int now = ended; now < 200; now = ended) ended.wait(now);
  EXPECT_EQ(together, 0);
}

// Threads with random delays add frames, flush and leave: each frame returns once, done or from a
// flush, in the order of its stream.
TEST(BatchCollector, GivesEachFrameBackOnceInOrderToItsStream) {
  for (uint32_t seed = 0; seed < 6; ++seed) {
    std::mt19937 setup(seed);
    const size_t batch_size = 1 + setup() % 5;
    const int streams = 1 + static_cast<int>(setup() % 5);
    std::mutex mutex;
    std::condition_variable changed;
    std::map<int, std::vector<int>> back, done;
    const auto collector = std::make_shared<BatchCollector>(batch_size, [&](BatchJobs& jobs) {
      EXPECT_LE(jobs.size(), batch_size);
      EXPECT_GE(jobs.size(), 1u);
      for (auto& job : jobs) job->done({}, {}, nullptr, 0);
    });
    std::vector<std::thread> threads;
    for (int s = 0; s < streams; ++s)
      threads.emplace_back([&, s, seed] {
        std::mt19937 random(seed * 100 + static_cast<uint32_t>(s));
        constexpr int kFrames = 150, kDepth = 8;
        auto stream = BatchCollector::join(collector, std::chrono::microseconds(random() % 300));
        int brought = 0;
        const auto note = [&](const NumberedJob::End& end) {
          std::lock_guard lock(mutex);
          EXPECT_EQ(end.job.stream, s);
          back[s].push_back(end.job.number);
          if (!end.dropped) done[s].push_back(end.job.number);
          changed.notify_all();
        };
        while (brought < kFrames) {
          stream->add(numbered(s, brought++, note));
          const uint32_t what = random() % 64;
          if (what < 16) std::this_thread::yield();
          if (what == 20)  // a random delay
            for (uint32_t i = random() % 500; i > 0; --i) std::this_thread::yield();
          if (what == 21) stream->pause();
          if (what == 22)
            for (const auto& job : stream->flush())
              note({number_of(*job), {}, {}, true, {}, 0, {}, {}});
          if (what == 23) {
            for (const auto& job : stream->flush())
              note({number_of(*job), {}, {}, true, {}, 0, {}, {}});
            stream = BatchCollector::join(collector, 200us);
          }
          std::unique_lock lock(mutex);
          changed.wait(lock, [&] { return brought - static_cast<int>(back[s].size()) < kDepth; });
        }
        stream->pause();
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return static_cast<int>(back[s].size()) == kFrames; });
      });
    for (auto& thread : threads) thread.join();
    for (int s = 0; s < streams; ++s) {
      EXPECT_TRUE(std::is_sorted(done[s].begin(), done[s].end())) << "seed " << seed;
      auto sorted = back[s];
      std::sort(sorted.begin(), sorted.end());
      for (int i = 0; i < static_cast<int>(sorted.size()); ++i)
        EXPECT_EQ(sorted[static_cast<size_t>(i)], i) << "seed " << seed << ", stream " << s;
    }
  }
}

}  // namespace batch_collector_test
}  // namespace weir::infer
