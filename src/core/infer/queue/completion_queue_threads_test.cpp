// Tests the order of the completion queue with many threads and flushes in between.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/completion_queue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <random>
#include <thread>
#include <utility>
#include <vector>

namespace weir::infer {
namespace completion_queue_threads_test {

using Queue = CompletionQueue<int>;

// Four workers finish in any order; the output is 0, 1, 2, ...
TEST(CompletionQueueThreads, RestoresTheOrderOfManyWorkers) {
  constexpr int kCount = 2000;
  Queue queue(8);
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::pair<Queue::Ticket, int>> work;
  bool done = false;
  std::vector<int> out;
  const auto push = [&](int entry) { out.push_back(entry); };
  std::vector<std::thread> workers;
  for (unsigned w = 0; w < 4; ++w)
    workers.emplace_back([&, random = std::mt19937(w)]() mutable {
      for (;;) {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return done || !work.empty(); });
        if (work.empty()) return;
        const auto at = work.begin() + static_cast<std::ptrdiff_t>(random() % work.size());
        const auto item = *at;
        work.erase(at);
        lock.unlock();
        queue.complete(item.first, item.second);
        queue.drain(push);
      }
    });
  for (int i = 0; i < kCount; ++i) {
    const auto ticket = queue.submit();
    std::lock_guard lock(mutex);
    work.emplace_back(*ticket, i);
    changed.notify_one();
  }
  {
    std::lock_guard lock(mutex);
    done = true;
    changed.notify_all();
  }
  for (auto& worker : workers) worker.join();
  queue.drain(push);
  std::vector<int> expected(kCount);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(out, expected);
}

// Each worker adds 0 to 4 entries per ticket: they stay together and in order.
TEST(CompletionQueueThreads, RestoresTheOrderOfSeveralEntriesEach) {
  constexpr int kCount = 1000, kWorkers = 3;
  Queue queue(kWorkers);
  std::vector<int> out;
  std::mutex mutex;  // guards next and the order of submit()
  int next = 0;
  const auto push = [&](int entry) { out.push_back(entry); };
  std::vector<std::thread> workers;
  for (int w = 0; w < kWorkers; ++w)
    workers.emplace_back([&] {
      for (;;) {
        std::unique_lock lock(mutex);
        const int i = next++;
        if (i >= kCount) return;
        const auto ticket = queue.submit();
        lock.unlock();
        for (int part = 0; part < i % 5; ++part) {
          queue.add(*ticket, i * 10 + part);
          queue.drain(push);
        }
        queue.end(*ticket);
        queue.drain(push);
      }
    });
  for (auto& worker : workers) worker.join();
  queue.drain(push);
  std::vector<int> expected;
  for (int i = 0; i < kCount; ++i)
    for (int part = 0; part < i % 5; ++part) expected.push_back(i * 10 + part);
  EXPECT_EQ(out, expected);
}

// Flushes while others submit and complete: no thread hangs, and the output stays in order.
TEST(CompletionQueueThreads, SurvivesFlushesUnderThreads) {
  Queue queue(2);
  std::vector<int> out;
  std::thread submitter([&] {
    for (int i = 0; i < 5000; ++i) {
      const auto ticket = queue.submit();
      if (!ticket) continue;
      queue.complete(*ticket, i);
      queue.drain([&](int entry) { out.push_back(entry); });
    }
  });
  for (int i = 0; i < 500; ++i) {
    queue.flush();
    queue.resume();
  }
  submitter.join();
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
}

}  // namespace completion_queue_threads_test
}  // namespace weir::infer
