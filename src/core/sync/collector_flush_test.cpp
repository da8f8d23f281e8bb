// Flushes of a collector: only the first and the last pad flush the output, and nothing is emitted
// in between.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/collector_test_support.hpp"

namespace weir::sync {
namespace collector_flush_test {

TEST_F(Collecting, FlushWakesTheThreadOfItsPadOnly) {
  const QueueId a = collector.add(), b = collector.add(), c = collector.add();
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  wait_for_waiting(2);
  EXPECT_TRUE(flush_start(a));
  EXPECT_EQ(first.get(), kFlushing);
  wait_for_waiting(1);
  EXPECT_EQ(collector.offer(a, 9, 10), kFlushing);
  EXPECT_TRUE(flush_stop(a));
  auto again = offer(a, 3, 10);
  wait_for_waiting(2);
  EXPECT_EQ(collector.offer(c, 4, 10), kOk);
  EXPECT_EQ(second.get(), kOk);
  EXPECT_EQ(again.get(), kOk);
  EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{3, 2, 4}}));
  EXPECT_EQ(dropped(DropReason::Flush), 2u);
}

TEST_F(Collecting, OnlyTheFirstAndTheLastFlushCount) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_TRUE(flush_start(a));
  EXPECT_FALSE(flush_start(b));
  EXPECT_FALSE(flush_stop(a));
  EXPECT_TRUE(flush_stop(b));
  EXPECT_FALSE(flush_stop(b));
}

TEST_F(Collecting, FlushForgetsTheTime) {
  const QueueId a = collector.add();
  EXPECT_EQ(collector.offer(a, 1, 100), kOk);
  EXPECT_TRUE(flush_start(a));
  EXPECT_TRUE(flush_stop(a));
  EXPECT_EQ(collector.offer(a, 2, 5), kOk);
  EXPECT_EQ(out.times, (std::vector<Time>{100, 5}));
}

TEST_F(Collecting, AFlushOfARemovedPadIsIgnored) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_FALSE(collector.remove(b));
  EXPECT_FALSE(flush_start(b));
  EXPECT_EQ(collector.offer(a, 1, 10), kOk) << "nothing flushes";
}

TEST_F(Collecting, RemovalOfTheOnlyPadThatFlushesEndsTheFlush) {
  const QueueId a = collector.add(), b = collector.add(), c = collector.add();
  EXPECT_TRUE(flush_start(b));
  EXPECT_FALSE(flush_start(c));
  EXPECT_FALSE(collector.remove(c));
  EXPECT_TRUE(collector.remove(b));
  collector.flush_sent();
  EXPECT_EQ(collector.offer(a, 1, 10), kOk);
}

TEST_F(Collecting, AFlushEndsAfterItsStartWasSent) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_TRUE(collector.flush_start(b));
  std::atomic<bool> start_was_sent = false;
  auto removal = std::async(std::launch::async, [&] {
    const bool due = collector.remove(b);
    EXPECT_TRUE(start_was_sent);
    collector.flush_sent();
    return due;
  });
  start_was_sent = true;
  collector.flush_sent();
  EXPECT_TRUE(removal.get());
  EXPECT_EQ(collector.offer(a, 1, 10), kOk);
}

TEST_F(Collecting, ANewFlushBeginsAfterTheEndOfTheLastOneWasSent) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_TRUE(collector.flush_start(a));
  collector.flush_sent();
  EXPECT_TRUE(collector.flush_stop(a));
  std::atomic<bool> stop_was_sent = false;
  auto start = std::async(std::launch::async, [&] {
    const bool due = collector.flush_start(b);
    EXPECT_TRUE(stop_was_sent);
    return due;
  });
  stop_was_sent = true;
  collector.flush_sent();
  EXPECT_TRUE(start.get());
}

// Downstream still rejects buffers before FLUSH_STOP, which would stop the other pads for good.
TEST_F(Collecting, NothingIsEmittedUntilTheEndOfAFlushWasSent) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_TRUE(flush_start(a));
  EXPECT_FALSE(flush_start(b));
  EXPECT_FALSE(flush_stop(a));
  EXPECT_TRUE(collector.flush_stop(b));
  out.flow = kFlushing;
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  wait_for_waiting(2);
  EXPECT_EQ(out.count(), 0u);
  out.flow = kOk;
  collector.flush_sent();
  EXPECT_EQ(first.get(), kOk);
  EXPECT_EQ(second.get(), kOk);
  EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1, 2}}));
}

TEST_F(Collecting, TheLastEndIsPassedOnAfterTheEndOfAFlushWasSent) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_TRUE(flush_start(a));
  EXPECT_TRUE(collector.flush_stop(a));
  auto ends = std::async(std::launch::async, [&] { collector.end(a), collector.end(b); });
  wait_for_waiting(1);
  EXPECT_FALSE(out.ended);
  collector.flush_sent();
  ends.get();
  EXPECT_TRUE(out.ended);
}

TEST_F(Collecting, AcquiringTheOutputWaitsForTheEndOfAFlush) {
  const QueueId a = collector.add(), b = collector.add();
  EXPECT_TRUE(flush_start(a));
  EXPECT_TRUE(collector.flush_stop(a));
  std::atomic<bool> was_sent = false;
  auto use = std::async(std::launch::async,
                        [&] { return collector.use_output(b, [&] { EXPECT_TRUE(was_sent); }); });
  was_sent = true;
  collector.flush_sent();
  EXPECT_TRUE(use.get());
}

TEST_F(Collecting, AFlushOfAnotherPadIsNotReportedAsATooSmallBound) {
  const QueueId a = collector.add(), b = collector.add();
  collector.configure({Mode::Refresh, {}, {}}, OnBackwardsTime::Pass, {}, 50);
  auto kept = std::async(std::launch::async, [&] { return collector.offer(a, 1, 0, 20); });
  EXPECT_EQ(collector.offer(b, 2, 0, 20), kOk);
  EXPECT_EQ(kept.get(), kOk);
  EXPECT_TRUE(flush_start(b));
  auto next = std::async(std::launch::async, [&] { return collector.offer(a, 3, 10, 20); });
  wait_for_waiting(1);
  EXPECT_TRUE(flush_stop(b));
  EXPECT_EQ(collector.offer(b, 4, 10, 20), kOk);
  EXPECT_EQ(next.get(), kOk);
  EXPECT_TRUE(out.errors.empty());
}

TEST_F(Collecting, AnOutputInProgressIsFinishedBeforeAFlushEnds) {
  out.hold = true;
  const QueueId a = collector.add(), b = collector.add();
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  EXPECT_TRUE(becomes_true([&] { return ledger.snapshot().consumed >= 2; }, "2 frames consumed"));
  EXPECT_TRUE(collector.flush_start(a));
  collector.flush_sent();
  auto stopped = std::async(std::launch::async, [&] { return flush_stop(a); });
  EXPECT_EQ(out.count(), 0u);
  out.gate.set_value();
  EXPECT_TRUE(stopped.get());
  EXPECT_EQ(out.count(), 1u);
  first.get(), second.get();
}

}  // namespace collector_flush_test
}  // namespace weir::sync
