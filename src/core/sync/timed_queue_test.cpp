// Two threads pass items by time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/timed_queue.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace weir::sync {
namespace timed_queue_test {

using Items = std::vector<int64_t>;
using Outcome = TimedOutcome;
constexpr std::chrono::nanoseconds kLong = std::chrono::minutes(2);

TEST(TimedQueue, GivesTheItemOfTheSameTime) {
  TimedQueue<Items> queue;
  Items out;
  for (const int64_t time : {10, 20, 40}) queue.push(time, {time});
  EXPECT_EQ(queue.take(20, kLong, &out), Outcome::Found);
  EXPECT_EQ(out, (Items{20}));
  EXPECT_EQ(queue.unused(), 1u);
  EXPECT_EQ(queue.take(30, kLong, &out), Outcome::None);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(queue.take(40, kLong, &out), Outcome::Found);
  EXPECT_EQ(queue.unused(), 1u);
}

TEST(TimedQueue, DoesNotWaitForItemsThatCannotArrive) {
  TimedQueue<Items> queue;
  Items out;
  queue.advance(11);
  EXPECT_EQ(queue.take(10, kLong, &out), Outcome::None);
  EXPECT_EQ(queue.take(11, std::chrono::nanoseconds(1), &out), Outcome::Late);
  queue.end();
  EXPECT_EQ(queue.take(12, kLong, &out), Outcome::None);
  queue.clear();
  EXPECT_EQ(queue.take(1, std::chrono::nanoseconds(0), &out), Outcome::Late);
  queue.flush(true);
  EXPECT_EQ(queue.take(2, kLong, &out), Outcome::Flushed);
  queue.flush(false);
  queue.push(3, {});
  EXPECT_EQ(queue.take(3, kLong, &out), Outcome::Found);
}

TEST(TimedQueue, WaitsForAnotherThread) {
  TimedQueue<Items> queue;
  std::thread other([&] {
    for (int64_t time = 0; time < 1000; ++time) {
      if (time % 3 == 0)
        queue.advance(time + 1);
      else
        queue.push(time, {time});
    }
    queue.end();
  });
  Items out;
  uint64_t found = 0;
  for (int64_t time = 500; time < 1003; ++time) {
    const auto outcome = queue.take(time, kLong, &out);
    EXPECT_TRUE(outcome == Outcome::Found || outcome == Outcome::None);
    if (outcome == Outcome::Found) {
      ++found;
      EXPECT_EQ(out[0], time);
      EXPECT_NE(time % 3, 0);
    }
  }
  other.join();
  EXPECT_LE(found, 333u);
  EXPECT_EQ(found + queue.unused(), 666u);
}

TEST(TimedQueue, CountsItemsThatArriveDuringAFlush) {
  TimedQueue<Items> queue;
  queue.push(1, {1});
  EXPECT_EQ(queue.waiting(), 1u);
  queue.flush(true);
  queue.push(2, {2});
  EXPECT_EQ(queue.waiting(), 1u);
  EXPECT_EQ(queue.unused(), 1u);
  queue.clear();
  EXPECT_EQ(queue.waiting(), 0u);
  EXPECT_EQ(queue.unused(), 2u);
}

TEST(TimedQueue, StartsAgainAfterItsEnd) {
  TimedQueue<Items> queue;
  Items out;
  queue.end();
  EXPECT_EQ(queue.take(1, kLong, &out), Outcome::None);
  queue.push(2, {2});
  EXPECT_EQ(queue.take(2, kLong, &out), Outcome::Found);
  EXPECT_EQ(queue.take(3, std::chrono::nanoseconds(1), &out), Outcome::Late);
}

TEST(TimedQueue, IsBounded) {
  TimedQueue<Items> queue;
  for (size_t i = 0; i < kTimedQueueLimit + 5; ++i) queue.push(static_cast<int64_t>(i), {});
  EXPECT_EQ(queue.unused(), 5u);
  Items out;
  EXPECT_EQ(queue.take(4, kLong, &out), Outcome::None);
  EXPECT_EQ(queue.take(5, kLong, &out), Outcome::Found);
}

}  // namespace timed_queue_test
}  // namespace weir::sync
