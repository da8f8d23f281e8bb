// The collector under threads: every waiting thread is woken and every frame is counted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/collector_test_support.hpp"

namespace weir::sync {
namespace collector_test {

using namespace std::chrono_literals;

TEST_F(Collecting, AThreadWaitsUntilItsFrameIsTaken) {
  const QueueId a = collector.add(), b = collector.add();
  auto first = offer(a, 1, 10);
  wait_for_waiting(1);
  EXPECT_EQ(out.count(), 0u);
  EXPECT_EQ(collector.offer(b, 2, 10), kOk);
  EXPECT_EQ(first.get(), kOk);
  EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1, 2}}));
  EXPECT_EQ(ledger.snapshot().consumed, 2u);
}

TEST_F(Collecting, HoldsBytesUpToTheBound) {
  const QueueId a = collector.add(), b = collector.add();
  collector.configure({Mode::NoSync, {}, {}}, OnBackwardsTime::Pass, {}, 100);
  for (int round = 0; round < 3; ++round) {
    auto first = std::async(std::launch::async, [&] { return collector.offer(a, 1, 0, 30); });
    EXPECT_EQ(collector.offer(b, 2, 0, 20), kOk);
    EXPECT_EQ(first.get(), kOk);
  }
  EXPECT_EQ(collector.bytes_held(), (std::pair<uint64_t, uint64_t>{50, 100}))
      << "each queue keeps a frame until the next is taken";
  EXPECT_TRUE(out.errors.empty());
}

TEST_F(Collecting, ReportsTheBoundThatTheStreamsNeed) {
  const QueueId a = collector.add(), b = collector.add();
  collector.configure({Mode::NoSync, {}, {}}, OnBackwardsTime::Pass, {}, 49);
  auto first = std::async(std::launch::async, [&] { return collector.offer(a, 1, 0, 30); });
  wait_for_waiting(1);
  EXPECT_EQ(collector.offer(b, 2, 0, 20), kRefused) << "a waits for b";
  EXPECT_EQ(first.get(), kRefused);
  ASSERT_EQ(out.errors.size(), 1u);
  EXPECT_SAYS(out.errors[0], "exceed max-bytes");
  EXPECT_SAYS(out.errors[0], "30 bytes held and a frame of 20 in addition, max-bytes=49");
  EXPECT_SAYS(out.errors[0], "fix: max-bytes=50");
  EXPECT_EQ(dropped(DropReason::Error), 2u);
}

TEST_F(Collecting, AcceptsASingleFrameAboveTheBound) {
  const QueueId a = collector.add();
  collector.configure({Mode::NoSync, {}, {}}, OnBackwardsTime::Pass, {}, 10);
  EXPECT_EQ(collector.offer(a, 1, 0, 1000), kOk);
}

TEST_F(Collecting, WaitsForAnOutputInProgressBeyondTheBound) {
  const QueueId a = collector.add(), b = collector.add(), c = collector.add();
  collector.configure({Mode::Refresh, {}, {}}, OnBackwardsTime::Pass, {}, 80);
  const auto push = [&](QueueId queue, int frame) {
    return std::async(std::launch::async,
                      [=, this] { return collector.offer(queue, frame, 0, 20); });
  };
  auto one = push(a, 1), two = push(b, 2), three = push(c, 3);
  EXPECT_EQ(one.get() + two.get() + three.get(), kOk);
  const size_t before = out.count();  // each pad keeps a frame: 60
  out.hold = true;
  auto making = push(a, 4);
  EXPECT_TRUE(becomes_true([&] { return collector.bytes_held().second >= 80; }, "80 bytes held"));
  auto next = push(b, 5);
  wait_for_waiting(1);
  auto beyond = push(c, 6);
  wait_for_waiting(2);
  EXPECT_EQ(collector.bytes_held().first, 80u);
  out.hold = false;
  out.gate.set_value();
  EXPECT_EQ(making.get() + next.get() + beyond.get(), kOk);
  EXPECT_EQ(out.count(), before + 3);
  EXPECT_EQ(collector.bytes_held().second, 80u);
}

TEST_F(Collecting, StopWakesThreadsThatWaitForBytes) {
  const QueueId a = collector.add(), b = collector.add();
  collector.configure({Mode::Refresh, {}, {}}, OnBackwardsTime::Pass, {}, 60);
  auto first = std::async(std::launch::async, [&] { return collector.offer(a, 1, 0, 20); });
  EXPECT_EQ(collector.offer(b, 2, 0, 20), kOk);
  EXPECT_EQ(first.get(), kOk);
  out.hold = true;
  auto second = std::async(std::launch::async, [&] { return collector.offer(a, 3, 0, 20); });
  EXPECT_TRUE(becomes_true([&] { return collector.bytes_held().second >= 60; }, "60 bytes held"));
  auto third = std::async(std::launch::async, [&] { return collector.offer(b, 4, 0, 41); });
  wait_for_waiting(1);
  EXPECT_TRUE(flush_start(b));
  EXPECT_EQ(third.get(), kFlushing);
  EXPECT_EQ(dropped(DropReason::Flush), 1u);
  out.gate.set_value();
  second.get();
}

TEST_F(Collecting, StopWakesWaitingThreads) {
  const QueueId a = collector.add();
  collector.add();
  auto first = offer(a, 1, 10);
  wait_for_waiting(1);
  collector.stop();
  EXPECT_EQ(first.get(), kFlushing);
  EXPECT_EQ(dropped(DropReason::Flush), 1u);
  EXPECT_EQ(collector.offer(a, 2, 20), kFlushing);
  EXPECT_EQ(ledger.snapshot().held(), 0u);
}

TEST_F(Collecting, RemovalOfAPadWakesItAndUnblocksTheOthers) {
  const QueueId a = collector.add(), b = collector.add(), c = collector.add();
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  wait_for_waiting(2);
  collector.remove(b);
  EXPECT_EQ(second.get(), kFlushing);
  collector.remove(c);
  EXPECT_EQ(first.get(), kOk);
  EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1}}));
  EXPECT_EQ(collector.offer(b, 3, 20), kFlushing);
}

TEST_F(Collecting, ARemovalLeavesTheOutputToWaitingThreads) {
  const QueueId a = collector.add(), b = collector.add(), c = collector.add();
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  wait_for_waiting(2);
  collector.remove(c);
  EXPECT_EQ(first.get(), kOk);
  EXPECT_EQ(second.get(), kOk);
  EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1, 2}}));
  ASSERT_EQ(out.threads.size(), 1u);
  EXPECT_NE(out.threads[0], std::this_thread::get_id());
}

TEST_F(Collecting, RemovalMakesNoOutputUntilProceedIsCalled) {
  use(Mode::Refresh);
  const QueueId a = collector.add(), b = collector.add();
  collector.end(a);
  EXPECT_FALSE(collector.remove(b));
  EXPECT_FALSE(out.ended);
  collector.proceed();
  EXPECT_TRUE(out.ended);
}

TEST_F(Collecting, AcquiringTheOutputWaitsForEmittedFrames) {
  const QueueId a = collector.add(), b = collector.add();
  out.hold = true;
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  EXPECT_TRUE(becomes_true([&] { return ledger.snapshot().consumed == 2; }, "an output"));
  std::atomic<size_t> rows = 0;
  auto use = std::async(std::launch::async,
                        [&] { return collector.use_output(b, [&] { rows = out.count(); }); });
  out.hold = false;
  out.gate.set_value();
  EXPECT_TRUE(use.get());
  EXPECT_EQ(rows, 1u);
  first.get(), second.get();
}

TEST_F(Collecting, RemovalEndsTheWaitForTheOutput) {
  use(Mode::Refresh);
  const QueueId a = collector.add(), b = collector.add();
  auto first = offer(a, 1, 10), second = offer(b, 2, 10);
  first.get(), second.get();
  out.hold = true;
  auto third = offer(a, 3, 20);
  EXPECT_TRUE(becomes_true([&] { return ledger.snapshot().consumed == 3; }, "an output"));
  bool was_used = false;
  auto use = std::async(std::launch::async,
                        [&] { return collector.use_output(b, [&] { was_used = true; }); });
  EXPECT_FALSE(collector.remove(b));
  EXPECT_FALSE(use.get());
  EXPECT_FALSE(was_used);
  out.hold = false;
  out.gate.set_value();
  EXPECT_EQ(third.get(), kOk);
}

TEST_F(Collecting, AStartWaitsForAnOutputFromBeforeTheStop) {
  const QueueId a = collector.add();
  out.hold = true;
  auto first = offer(a, 1, 10);
  EXPECT_TRUE(becomes_true([&] { return ledger.snapshot().consumed == 1; }, "a frame in work"));
  collector.stop();
  out.flow = kFlushing;
  auto started = std::async(std::launch::async, [&] { collector.start(); });
  out.hold = false;
  out.gate.set_value();
  first.get();
  started.get();
  out.flow = kOk;
  EXPECT_EQ(collector.offer(a, 2, 20), kOk) << "what came of that output is forgotten";
}

TEST_F(Collecting, AnInactivePadReturnsAtOnce) {
  const QueueId a = collector.add();
  collector.add();
  auto first = offer(a, 1, 10);
  wait_for_waiting(1);
  collector.set_active(a, false);
  EXPECT_EQ(first.get(), kFlushing);
}

TEST_F(Collecting, TheEndOfOnePadEndsTheOthers) {
  const QueueId a = collector.add(), b = collector.add();
  auto first = offer(a, 1, 10);
  wait_for_waiting(1);
  collector.end(b);
  EXPECT_TRUE(out.ended);
  const int flow = first.get();
  EXPECT_TRUE(flow == kOk || flow == kEnded);
  EXPECT_EQ(collector.offer(a, 2, 20), kEnded);
  EXPECT_EQ(dropped(DropReason::Eos), 2u);
  EXPECT_EQ(ledger.snapshot().held(), 0u);
}

TEST_F(Collecting, RemovalOfTheLastActivePadEndsTheStream) {
  use(Mode::Refresh);
  const QueueId a = collector.add(), b = collector.add();
  collector.end(a);
  EXPECT_FALSE(out.ended);
  collector.remove(b);
  collector.proceed();
  EXPECT_TRUE(out.ended);
}

TEST_F(Collecting, AllPadsReceiveTheConsumersFlowReturn) {
  out.flow = kRefused;
  const QueueId a = collector.add(), b = collector.add();
  auto first = offer(a, 1, 10);
  wait_for_waiting(1);
  EXPECT_EQ(collector.offer(b, 2, 10), kRefused);
  first.get();
  EXPECT_EQ(collector.offer(a, 3, 20), kRefused);
  EXPECT_EQ(dropped(DropReason::Error), 1u);
}

TEST_F(Collecting, ALateLinkIsUsed) {
  out.flow = kNotLinked;
  const QueueId a = collector.add();
  EXPECT_EQ(collector.offer(a, 1, 10), kNotLinked);
  EXPECT_EQ(collector.offer(a, 2, 20), kNotLinked);
  out.flow = kOk;
  EXPECT_EQ(collector.offer(a, 3, 30), kOk);
  EXPECT_EQ(out.count(), 3u);
}

TEST_F(Collecting, AMissingPadIsNotWaitedForLongerThanMaxWait) {
  use(Mode::Slowest, 1ms);
  const QueueId a = collector.add(), b = collector.add();
  auto first = offer(a, 1, 10);
  EXPECT_EQ(collector.offer(b, 2, 10), kOk);
  first.get();
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(collector.offer(a, 10 + i, 20 + static_cast<Time>(i)), kOk);
  EXPECT_EQ(out.rows.back(), (std::vector<int>{19, 2}));
  EXPECT_GE(collector.counts().missed, 1u);
  EXPECT_EQ(ledger.snapshot().held(), 0u);
}

TEST_F(Collecting, AStallingGraphFailsInsteadOfWaiting) {
  out.stalls = true;
  const QueueId a = collector.add();
  collector.add();
  EXPECT_EQ(collector.offer(a, 1, 10), kRefused);
  ASSERT_EQ(out.errors.size(), 1u);
  EXPECT_EQ(dropped(DropReason::Error), 1u);
}

// A pad whose flow fails posts an error without a reason, so the error with the reason must be
// posted first.
TEST_F(Collecting, TheReasonIsPostedBeforeOthersFail) {
  for (const bool by_bytes : {false, true}) {
    Recorder consumer;
    Ledger counts;
    Collector<int> pads(&counts, &consumer);
    pads.configure({Mode::NoSync, {}, {}}, OnBackwardsTime::Pass, {}, by_bytes ? 10 : 0);
    pads.start();
    const QueueId a = pads.add(), b = pads.add();
    if (!by_bytes) pads.add();
    std::future<int> first =
        std::async(std::launch::async, [&] { return pads.offer(a, 1, 0, 10); });
    EXPECT_TRUE(becomes_true([&] { return pads.waiting() == 1; }, "a thread that waits"));
    auto before = std::future_status::ready;
    consumer.on_refused = [&] { before = first.wait_for(200ms); };
    consumer.stalls = !by_bytes;
    EXPECT_EQ(pads.offer(b, 2, 0, 10), kRefused);
    EXPECT_EQ(first.get(), kRefused);
    EXPECT_EQ(before, std::future_status::timeout);
  }
}

// Four pads at different rates, one of them removed and added again meanwhile, then the end.
TEST_F(Collecting, LosesNothingUncountedUnderThreads) {
  for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad, Mode::Refresh}) {
    Ledger counts;
    Recorder rows;
    Collector<int> mux(&counts, &rows);
    mux.configure({mode, {}, {}}, OnBackwardsTime::Pass, {});
    mux.start();
    std::vector<std::thread> threads;
    std::vector<QueueId> queues;
    for (Time p = 0; p < 4; ++p) queues.push_back(mux.add());
    for (Time p = 0; p < 4; ++p)
      threads.emplace_back([&, p] {
        for (Time i = 0; i < 200; ++i)
          if (mux.offer(queues[p], static_cast<int>(i), i * (5 + p)) != kOk) break;
        mux.end(queues[p]);
      });
    const QueueId late = mux.add();
    std::thread added([&] {
      mux.offer(late, 1, 100);
      mux.remove(late);
      mux.proceed();
    });
    added.join();
    for (auto& thread : threads) thread.join();
    EXPECT_TRUE(rows.ended) << to_string(mode);
    EXPECT_GT(rows.count(), 0u);
    EXPECT_EQ(counts.snapshot().held(), 0u) << to_string(mode);
  }
}

}  // namespace collector_test
}  // namespace weir::sync
