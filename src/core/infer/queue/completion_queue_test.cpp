// Tests order, limits and flushing of the completion queue.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/completion_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "becomes.hpp"

namespace weir::infer {
namespace completion_queue_test {

using Queue = CompletionQueue<int>;

std::vector<int> drained(Queue& queue) {
  std::vector<int> out;
  queue.drain([&](int entry) { out.push_back(entry); });
  return out;
}

TEST(CompletionQueue, DispatchesInTheOrderOfSubmission) {
  Queue queue(3);
  const auto a = queue.submit(), b = queue.submit(), c = queue.submit();
  EXPECT_TRUE(queue.complete(*c, 3));
  EXPECT_TRUE(drained(queue).empty()) << "the oldest is not finished";
  EXPECT_TRUE(queue.complete(*a, 1));
  EXPECT_EQ(drained(queue), (std::vector<int>{1}));
  EXPECT_TRUE(queue.complete(*b, 2));
  EXPECT_EQ(drained(queue), (std::vector<int>{2, 3}));
}

TEST(CompletionQueue, KeepsTheOrderOfEvents) {
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

TEST(CompletionQueue, AcceptsAnyNumberOfEvents) {
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
  EXPECT_FALSE(second) << "finished work keeps its place until it is dispatched";
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

TEST(CompletionQueue, AFlushWakesWaitingCallers) {
  Queue queue(1);
  const auto a = queue.submit();
  ASSERT_TRUE(a);
  std::thread other([&] { EXPECT_FALSE(queue.submit()); });
  queue.flush();
  other.join();
}

TEST(CompletionQueue, RecountsItsEntriesAfterAFlushDuringDispatch) {
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

TEST(CompletionQueue, OneCallDispatchesAtATime) {
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

TEST(CompletionQueue, ANonBlockingCallerGetsNoTicketWithoutRoom) {
  Queue queue(1);
  const auto a = queue.try_submit();
  ASSERT_TRUE(a);
  EXPECT_FALSE(queue.try_submit());
  queue.set_depth(2);
  EXPECT_TRUE(queue.try_submit());
  queue.flush();
  EXPECT_FALSE(queue.try_submit());
}

TEST(CompletionQueue, SkipsAbandonedWork) {
  Queue queue(3);
  const auto a = queue.submit(), b = queue.submit(), c = queue.submit();
  EXPECT_TRUE(queue.end(*b));
  EXPECT_TRUE(queue.try_submit()) << "its place is free at once";
  queue.complete(*c, 3);
  queue.complete(*a, 1);
  EXPECT_EQ(drained(queue), (std::vector<int>{1, 3}));
}

TEST(CompletionQueue, SkipsAbandonedWorkAtItsHead) {
  Queue queue(2);
  const auto a = queue.submit(), b = queue.submit();
  queue.append(100);
  queue.complete(*b, 2);
  queue.end(*a);
  EXPECT_EQ(drained(queue), (std::vector<int>{2, 100}));
}

// Work that is replaced by newer work leaves no entries, however long the oldest takes.
TEST(CompletionQueue, AbandoningTheNewestTicketRemovesIt) {
  Queue queue(2);
  const auto oldest = queue.submit();
  for (int i = 0; i < 100000; ++i) {
    const auto ticket = queue.try_submit();
    ASSERT_TRUE(ticket) << i;
    ASSERT_TRUE(queue.end(*ticket));
  }
  queue.append(100);
  queue.complete(*oldest, 1);
  EXPECT_EQ(drained(queue), (std::vector<int>{1, 100}));
  EXPECT_TRUE(queue.wait_until_empty());
}

TEST(CompletionQueue, HoldsWorkUntilItIsFlushed) {
  Queue queue(2);
  const auto a = queue.submit();
  EXPECT_TRUE(queue.holds(*a));
  queue.flush();
  EXPECT_FALSE(queue.holds(*a));
  queue.resume();
  EXPECT_TRUE(queue.holds(*queue.submit()));
  EXPECT_FALSE(queue.holds(*a));
}

TEST(CompletionQueue, AFlushReportsAbandonedWork) {
  Queue queue(1);
  const auto a = queue.submit();
  queue.flush();
  queue.resume();
  const auto b = queue.submit();
  EXPECT_FALSE(queue.end(*a));
  EXPECT_FALSE(queue.try_submit()) << "the place of `b` is taken";
  EXPECT_TRUE(queue.end(*b));
}

TEST(CompletionQueue, WaitsUntilOthersHaveDispatchedAll) {
  Queue queue(2);
  const auto a = queue.submit(), b = queue.submit();
  std::atomic<int> seen{0};
  std::thread other([&] {
    queue.complete(*b, 2);
    queue.complete(*a, 1);
    queue.drain([&](int) { ++seen; });
  });
  EXPECT_TRUE(queue.wait_until_empty());
  EXPECT_EQ(seen, 2);
  other.join();
}

TEST(CompletionQueue, WaitsForNothingThatIsFlushed) {
  Queue queue(1);
  const auto a = queue.submit();
  ASSERT_TRUE(a);
  std::thread other([&] { queue.flush(); });
  EXPECT_FALSE(queue.wait_until_empty());
  other.join();
}

// After a flush no earlier entry may still be dispatched, or it would follow new ones.
TEST(CompletionQueue, AcceptsNothingAfterAFlushWhileOthersDispatch) {
  Queue queue(1);
  std::atomic<bool> flushed{false}, handed_over{false};
  std::thread other([&] {
    queue.complete(*queue.submit(), 1);
    queue.drain([&](int) {
      queue.flush();
      flushed = true;
      for (int i = 0; i < 100; ++i) std::this_thread::yield();
      handed_over = true;
    });
  });
  EXPECT_TRUE(becomes_true([&] { return flushed.load(); }, "the flush"));
  queue.resume();
  EXPECT_TRUE(handed_over);
  other.join();
}

TEST(CompletionQueue, DispatchesTheOldestTicketsOutputsAtOnce) {
  Queue queue(2);
  const auto a = queue.submit(), b = queue.submit();
  EXPECT_TRUE(queue.add(*a, 1));
  EXPECT_EQ(drained(queue), (std::vector<int>{1}));
  EXPECT_TRUE(queue.add(*b, 10));
  EXPECT_TRUE(queue.add(*b, 11));
  EXPECT_TRUE(queue.add(*b, 12));
  EXPECT_TRUE(drained(queue).empty()) << "not its turn";
  EXPECT_TRUE(queue.add(*a, 2));
  EXPECT_TRUE(queue.add(*a, 3));
  EXPECT_EQ(drained(queue), (std::vector<int>{2, 3}));
  EXPECT_TRUE(queue.end(*a));
  EXPECT_EQ(drained(queue), (std::vector<int>{10, 11, 12})) << "now it is the oldest";
  EXPECT_TRUE(queue.complete(*b, 13));
  EXPECT_EQ(drained(queue), (std::vector<int>{13}));
}

TEST(CompletionQueue, SkipsATicketWithoutOutputs) {
  Queue queue(3);
  const auto a = queue.submit(), b = queue.submit();
  queue.append(100);
  EXPECT_TRUE(queue.complete(*b, 2));
  EXPECT_TRUE(queue.end(*a));
  EXPECT_EQ(drained(queue), (std::vector<int>{2, 100}));
}

TEST(CompletionQueue, AcceptsNothingAfterTheEndOfATicket) {
  Queue queue(2);
  const auto a = queue.submit(), b = queue.submit();
  EXPECT_TRUE(queue.end(*b));
  EXPECT_FALSE(queue.add(*b, 1)) << "it still waits for its turn";
  EXPECT_FALSE(queue.end(*b));
  EXPECT_FALSE(queue.complete(*b, 1));
  EXPECT_TRUE(queue.end(*a));
  EXPECT_TRUE(drained(queue).empty());
  EXPECT_FALSE(queue.add(*a, 1)) << "it is gone";
  const auto last = queue.submit();
  EXPECT_TRUE(queue.end(*last));
  const auto next = queue.submit();
  EXPECT_FALSE(queue.add(*last, 1)) << "though its place is another's now";
  EXPECT_TRUE(queue.complete(*next, 5));
  EXPECT_EQ(drained(queue), (std::vector<int>{5}));
}

TEST(CompletionQueue, KeepsATicketUntilItsLastEntryIsDispatched) {
  Queue queue(1);
  const auto a = queue.submit();
  queue.add(*a, 1);
  EXPECT_EQ(drained(queue), (std::vector<int>{1}));
  EXPECT_FALSE(queue.try_submit()) << "it is open";
  queue.add(*a, 2);
  queue.end(*a);
  EXPECT_FALSE(queue.try_submit()) << "its entry waits";
  EXPECT_EQ(drained(queue), (std::vector<int>{2}));
  const auto b = queue.try_submit();
  ASSERT_TRUE(b);
  queue.add(*b, 3);
  drained(queue);
  queue.end(*b);
  EXPECT_TRUE(queue.try_submit()) << "nothing of it waits";
}

TEST(CompletionQueue, DropsTheEntriesOfOpenTicketsWhenItIsFlushed) {
  Queue queue(2);
  const auto a = queue.submit(), b = queue.submit();
  for (int i = 0; i < 3; ++i) queue.add(*b, i);
  queue.add(*a, 9);
  EXPECT_EQ(queue.flush(), (std::vector<int>{9, 0, 1, 2}));
  EXPECT_FALSE(queue.add(*a, 1));
  EXPECT_FALSE(queue.end(*b));
  queue.resume();
  EXPECT_TRUE(queue.complete(*queue.submit(), 3));
  EXPECT_TRUE(queue.complete(*queue.submit(), 4)) << "both places are free";
  EXPECT_EQ(drained(queue), (std::vector<int>{3, 4}));
}

TEST(CompletionQueue, AcceptsMoreWhenItBecomesDeeper) {
  Queue queue(1);
  const auto a = queue.submit();
  std::thread other([&] { EXPECT_TRUE(queue.complete(*queue.submit(), 2)); });
  queue.set_depth(2);
  other.join();
  queue.complete(*a, 1);
  EXPECT_EQ(drained(queue), (std::vector<int>{1, 2}));
}

TEST(CompletionQueue, ReportsEntriesThatLeave) {
  Queue queue(2);
  const auto a = queue.submit(), b = queue.submit();
  EXPECT_TRUE(queue.is_next(*a));
  EXPECT_FALSE(queue.is_next(*b));
  queue.add(*b, 20);
  EXPECT_FALSE(queue.leaves()) << "it waits for the end of the oldest";
  queue.add(*a, 10);
  EXPECT_TRUE(queue.leaves());
  bool while_handed_over = false;
  queue.drain([&](int) { while_handed_over = queue.leaves(); });
  EXPECT_TRUE(while_handed_over);
  EXPECT_FALSE(queue.leaves());
  queue.end(*a);
  EXPECT_TRUE(queue.leaves()) << "the next one's";
  EXPECT_EQ(drained(queue), std::vector<int>{20});
  EXPECT_TRUE(queue.is_next(*b));
}

TEST(CompletionQueue, RemovesTheOldestOfAKind) {
  Queue queue(2);
  const auto odd = [](int n) { return n % 2 == 1; };
  const auto a = queue.submit();
  queue.append(100);
  const auto b = queue.submit();
  for (const int n : {2, 3, 4}) queue.add(*a, n);
  for (const int n : {5, 6}) queue.add(*b, n);
  EXPECT_EQ(queue.take_oldest(odd), 3);
  EXPECT_EQ(queue.take_oldest(odd), 5);
  EXPECT_EQ(queue.take_oldest(odd), std::nullopt);
  queue.end(*a), queue.end(*b);
  EXPECT_EQ(drained(queue), (std::vector<int>{2, 4, 100, 6}));
}

TEST(CompletionQueue, ARemovedEntryMakesRoom) {
  Queue queue(1);
  const auto a = queue.submit();
  queue.complete(*a, 1);
  EXPECT_EQ(queue.take_oldest([](int) { return true; }), 1);
  EXPECT_TRUE(drained(queue).empty());
  const auto b = queue.try_submit();
  ASSERT_TRUE(b);
  queue.complete(*b, 2);
  EXPECT_EQ(drained(queue), std::vector<int>{2});
  EXPECT_TRUE(queue.wait_until_empty());
}

}  // namespace completion_queue_test
}  // namespace weir::infer
