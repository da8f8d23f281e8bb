// Order, bounds and flushing of the completion queue, alone and under threads.
#include "core/infer/completion_queue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <random>
#include <thread>

namespace weir::infer {
namespace {

using Queue = CompletionQueue<int>;

std::vector<int> drained(Queue& queue) {
  std::vector<int> out;
  queue.drain([&](int entry) { out.push_back(entry); });
  return out;
}

TEST(CompletionQueue, HandsOverInTheOrderOfSubmission) {
  Queue queue(3);
  const auto a = queue.submit(), b = queue.submit(), c = queue.submit();
  EXPECT_TRUE(queue.complete(*c, 3));
  EXPECT_TRUE(drained(queue).empty()) << "the oldest is not finished";
  EXPECT_TRUE(queue.complete(*a, 1));
  EXPECT_EQ(drained(queue), (std::vector<int>{1}));
  EXPECT_TRUE(queue.complete(*b, 2));
  EXPECT_EQ(drained(queue), (std::vector<int>{2, 3}));
}

TEST(CompletionQueue, KeepsEventsInTheirPlace) {
  Queue queue(2);
  const auto a = queue.submit();
  queue.append(100);
  const auto b = queue.submit();
  queue.append(200);
  queue.complete(*b, 2);
  EXPECT_TRUE(drained(queue).empty());
  queue.complete(*a, 1);
  EXPECT_EQ(drained(queue), (std::vector<int>{1, 100, 2, 200}));
}

TEST(CompletionQueue, TakesAnyNumberOfEvents) {
  Queue queue(1);
  const auto a = queue.submit();
  std::vector<int> expected{-1};
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(queue.append(i));
    expected.push_back(i);
  }
  queue.complete(*a, -1);
  EXPECT_EQ(drained(queue), expected);
}

TEST(CompletionQueue, WaitsForRoom) {
  Queue queue(1);
  const auto a = queue.submit();
  std::atomic<bool> second{false};
  std::thread other([&] {
    const auto b = queue.submit();
    second = true;
    queue.complete(*b, 2);
  });
  queue.complete(*a, 1);
  EXPECT_FALSE(second) << "finished work keeps its place until it is handed over";
  EXPECT_EQ(drained(queue), (std::vector<int>{1}));
  other.join();
  EXPECT_EQ(drained(queue), (std::vector<int>{2}));
}

TEST(CompletionQueue, DropsEverythingWhenItIsFlushed) {
  Queue queue(3);
  const auto a = queue.submit(), b = queue.submit();
  queue.append(100);
  queue.complete(*b, 2);
  EXPECT_EQ(queue.flush(), (std::vector<int>{2, 100}));
  EXPECT_FALSE(queue.complete(*a, 1)) << "from before the flush";
  EXPECT_FALSE(queue.submit());
  EXPECT_FALSE(queue.append(101));
  queue.resume();
  EXPECT_TRUE(drained(queue).empty());
  const auto c = queue.submit();
  EXPECT_TRUE(queue.complete(*c, 3));
  EXPECT_EQ(drained(queue), (std::vector<int>{3}));
}

TEST(CompletionQueue, LetsWaitingCallersGoWhenItIsFlushed) {
  Queue queue(1);
  const auto a = queue.submit();
  ASSERT_TRUE(a);
  std::thread other([&] { EXPECT_FALSE(queue.submit()); });
  queue.flush();
  other.join();
}

TEST(CompletionQueue, CountsPlacesAnewAfterAFlushInTheMiddleOfAHandOver) {
  Queue queue(1);
  queue.complete(*queue.submit(), 1);
  std::optional<Queue::Ticket> later;
  queue.drain([&](int) {
    queue.flush();
    queue.resume();
    later = queue.submit();
  });
  ASSERT_TRUE(later);
  std::atomic<bool> entered{false};
  std::thread other([&] { entered = queue.submit().has_value(); });
  EXPECT_FALSE(entered) << "the place of `later` is taken";
  queue.complete(*later, 2);
  EXPECT_EQ(drained(queue), (std::vector<int>{2}));
  other.join();
  EXPECT_TRUE(entered);
}

TEST(CompletionQueue, LetsOneCallHandOverAtATime) {
  Queue queue(2);
  queue.complete(*queue.submit(), 1);
  std::vector<int> inner, outer;
  queue.drain([&](int entry) {
    outer.push_back(entry);
    if (entry == 1) {
      queue.append(2);
      inner = drained(queue);
    }
  });
  EXPECT_TRUE(inner.empty());
  EXPECT_EQ(outer, (std::vector<int>{1, 2}));
}

// Four workers finish in any order; what comes out is 0, 1, 2, ...
TEST(CompletionQueue, RestoresTheOrderOfManyWorkers) {
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

// Flushing while others submit and complete: nobody hangs, and what comes out is still in order.
TEST(CompletionQueue, SurvivesFlushesUnderThreads) {
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

}  // namespace
}  // namespace weir::infer
