// Tests when batches are due, their content, and that no frame is lost.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/batch_queue.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/infer/queue/numbered_job_test_support.hpp"

namespace weir::infer {
namespace batch_queue_test {

using namespace std::chrono_literals;
using Time = BatchQueue::Time;

struct Collecting {
  explicit Collecting(size_t batch_size) : queue(batch_size) {}
  void add(BatchQueue::StreamId stream, int number = 0, std::chrono::milliseconds at = 0ms) {
    queue.add(stream, numbered(static_cast<int>(stream), number), Time{} + at);
  }
  bool due(std::chrono::milliseconds at = 0ms) const { return queue.due(Time{} + at); }
  std::vector<Numbered> take() {
    std::vector<Numbered> out;
    for (const auto& taken : queue.take()) out.push_back(number_of(*taken.job));
    return out;
  }
  BatchQueue queue;
};

TEST(BatchQueue, NothingIsDueWhereNothingWaits) {
  Collecting g(2);
  const auto a = g.queue.join(10ms);
  EXPECT_FALSE(g.due(1h));
  EXPECT_FALSE(g.queue.deadline());
  g.add(a);
  EXPECT_EQ(g.take().size(), 1u);
  EXPECT_FALSE(g.due(1h));
  EXPECT_TRUE(g.take().empty());
}

TEST(BatchQueue, ReturnsOnlyTheOldestFrameOfAStream) {
  Collecting g(2);
  const auto a = g.queue.join(10ms), b = g.queue.join(10ms);
  EXPECT_EQ(g.queue.take_oldest(a), nullptr);
  EXPECT_EQ(g.queue.take_oldest(b + 1), nullptr) << "a stream that is not there";
  g.add(b, 1, 0ms);
  g.add(a, 1, 1ms);
  g.add(a, 2, 5ms);
  const auto oldest = g.queue.take_oldest(a);
  ASSERT_TRUE(oldest);
  EXPECT_EQ(number_of(*oldest), (Numbered{static_cast<int>(a), 1}));
  EXPECT_EQ(g.take(), (std::vector<Numbered>{{static_cast<int>(b), 1}, {static_cast<int>(a), 2}}));
  EXPECT_TRUE(g.queue.empty());
  g.add(a, 3, 0ms);
  g.queue.take_oldest(a);
  EXPECT_FALSE(g.due(1h)) << "nothing waits any more";
}

TEST(BatchQueue, AFullBatchIsDueAtOnce) {
  Collecting g(3);
  const auto a = g.queue.join(1h);
  g.queue.join(1h);  // inactive: a full batch does not need it
  g.add(a, 1);
  g.add(a, 2);
  EXPECT_FALSE(g.due());
  g.add(a, 3);
  EXPECT_TRUE(g.due());
}

TEST(BatchQueue, APartialBatchIsDueAtTheTimeoutOfItsFirstFrame) {
  Collecting g(4);
  const auto a = g.queue.join(10ms), b = g.queue.join(30ms);
  g.queue.join(1ms);
  g.add(b, 1, 0ms);
  EXPECT_FALSE(g.due(29ms));
  EXPECT_TRUE(g.due(30ms));
  g.add(a, 1, 15ms);
  EXPECT_EQ(g.queue.deadline(), Time{} + 25ms) << "the earliest of all streams";
  EXPECT_FALSE(g.due(24ms));
  EXPECT_TRUE(g.due(25ms));
}

TEST(BatchQueue, ATimeoutOfCenturiesDoesNotWrapAround) {
  Collecting g(4);
  const auto a = g.queue.join(std::chrono::nanoseconds::max());
  g.add(a, 1, 1h);
  EXPECT_FALSE(g.due(24h * 365));
}

TEST(BatchQueue, DoesNotWaitWhenEveryStreamHasDeliveredItsPart) {
  Collecting g(8);
  const auto a = g.queue.join(1h), b = g.queue.join(1h), c = g.queue.join(1h);
  g.add(a, 1);
  g.add(a, 2);
  g.add(b, 1);
  g.add(b, 2);
  g.add(c, 1);
  EXPECT_FALSE(g.due()) << "8 / 3 = 2 frames are the share of each";
  g.add(c, 2);
  EXPECT_TRUE(g.due());
}

TEST(BatchQueue, AStreamThatMissedATimeoutIsNotWaitedForUntilItsNextFrame) {
  Collecting g(2);
  const auto a = g.queue.join(10ms), slow = g.queue.join(10ms), dead = g.queue.join(10ms);
  g.add(a, 1);
  EXPECT_FALSE(g.due(9ms));
  EXPECT_TRUE(g.due(10ms));
  g.take();
  g.add(slow, 1, 20ms);
  EXPECT_FALSE(g.due(20ms)) << "two frames are its part with one active stream";
  g.add(a, 2, 20ms);
  EXPECT_TRUE(g.due(20ms));
  g.take();
  g.add(a, 3, 40ms);
  EXPECT_FALSE(g.due(40ms)) << "the slow one was in the last batch";
  EXPECT_TRUE(g.queue.leave(dead).empty());
}

TEST(BatchQueue, APausedStreamDoesNotBlockOthers) {
  Collecting g(4);
  const auto a = g.queue.join(1h), b = g.queue.join(1h);
  g.add(a, 1);
  g.add(a, 2);
  EXPECT_FALSE(g.due());
  g.queue.pause(b);
  EXPECT_FALSE(g.due()) << "with one stream, its part is 4";
  g.queue.pause(a);
  EXPECT_TRUE(g.due()) << "no stream can deliver more";
  g.add(b, 1);
  EXPECT_FALSE(g.due()) << "b is back, and its share is 2";
}

TEST(BatchQueue, AStreamWithFramesInBatchesIsWaitedForWhileItHasFramesHere) {
  Collecting g(4);
  const auto a = g.queue.join(1h), b = g.queue.join(1h);
  g.add(a, 1);
  g.add(a, 2);
  g.add(b, 1);
  g.queue.pause_if_empty(b);
  EXPECT_FALSE(g.due()) << "it has one here, and its share is 2";
  g.add(b, 2);
  g.take();
  g.queue.pause_if_empty(b);
  for (int i = 3; i <= 6; ++i) g.add(a, i);
  EXPECT_EQ(g.take().size(), 4u);
  g.add(a, 7);
  g.queue.pause(a);
  EXPECT_TRUE(g.due()) << "b is not waited for";
}

TEST(BatchQueue, AStreamThatLeavesRemovesItsFramesAndDoesNotBlockOthers) {
  Collecting g(2);
  const auto a = g.queue.join(1h), b = g.queue.join(1h);
  g.add(a, 1);
  g.add(a, 2);
  const auto left = g.queue.leave(a);
  ASSERT_EQ(left.size(), 2u);
  EXPECT_EQ(number_of(*left[0]).number, 1);
  EXPECT_EQ(number_of(*left[1]).number, 2);
  EXPECT_TRUE(g.queue.empty());
  g.add(b, 1);
  EXPECT_FALSE(g.due());
  EXPECT_TRUE(g.queue.leave(a).empty()) << "it left already";
  EXPECT_EQ(g.queue.streams(), 1u);
}

TEST(BatchQueue, TakesTheOldestOfEachStreamBeforeTheSecondOfAny) {
  Collecting g(4);
  const auto fast = g.queue.join(1h), b = g.queue.join(1h), c = g.queue.join(1h);
  for (int i = 1; i <= 6; ++i) g.add(fast, i);
  g.add(c, 1);
  g.add(b, 1);
  EXPECT_EQ(g.take(), (std::vector<Numbered>{{static_cast<int>(fast), 1},
                                             {static_cast<int>(c), 1},
                                             {static_cast<int>(b), 1},
                                             {static_cast<int>(fast), 2}}));
  EXPECT_EQ(g.take().size(), 4u);
}

TEST(BatchQueue, MoreStreamsThanABatchHoldsAreServedInTurn) {
  Collecting g(2);
  std::vector<BatchQueue::StreamId> streams;
  for (int i = 0; i < 5; ++i) streams.push_back(g.queue.join(1h));
  for (const auto stream : streams) g.add(stream);
  std::vector<int> served;
  for (int batch = 0; batch < 3; ++batch)
    for (const auto& taken : g.take()) {
      served.push_back(taken.stream);
      g.add(static_cast<BatchQueue::StreamId>(taken.stream));
    }
  EXPECT_EQ(served, (std::vector<int>{1, 2, 3, 4, 5, 1}));
}

// Streams join, leave, flush, pause and stall at random: every frame leaves once, in the order of
// its stream, in a batch or with its stream; no batch is too big, and none waits longer than its
// time-out.
TEST(BatchQueue, KeepsEveryFrameOnceInOrder) {
  for (uint32_t seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<uint32_t>(n)); };
    const size_t batch_size = 1 + static_cast<size_t>(below(6));
    Collecting g(batch_size);
    std::map<BatchQueue::StreamId, int> brought, seen;
    std::vector<BatchQueue::StreamId> joined;
    const auto check = [&](const Numbered& left) {
      EXPECT_EQ(left.number, ++seen[static_cast<BatchQueue::StreamId>(left.stream)]) << seed;
    };
    std::chrono::milliseconds now = 0ms;
    for (int step = 0; step < 400; ++step) {
      now += std::chrono::milliseconds(below(4));
      const auto any = joined.empty() ? 0 : joined[static_cast<size_t>(below(joined.size()))];
      const int what = below(20);
      if (joined.empty() || what == 0) {
        joined.push_back(g.queue.join(std::chrono::milliseconds(below(9))));
      } else if (what == 1) {
        for (const auto& job : g.queue.leave(any)) check(number_of(*job));
        std::erase(joined, any);
      } else if (what == 2) {
        for (const auto& job : g.queue.clear(any)) check(number_of(*job));
      } else if (what == 3) {
        g.queue.pause(any);
      } else {
        g.add(any, ++brought[any], now);
      }
      if (const auto deadline = g.queue.deadline(); deadline && *deadline <= Time{} + now) {
        EXPECT_TRUE(g.due(now)) << seed;
      }
      if (!g.due(now)) continue;
      const auto batch = g.take();
      EXPECT_GE(batch.size(), 1u);
      EXPECT_LE(batch.size(), batch_size);
      for (const auto& left : batch) check(left);
    }
    for (const auto stream : joined)
      for (const auto& job : g.queue.leave(stream)) check(number_of(*job));
    EXPECT_EQ(brought, seen) << seed;
    EXPECT_TRUE(g.queue.empty());
  }
}

}  // namespace batch_queue_test
}  // namespace weir::infer
