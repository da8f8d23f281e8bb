// Frames that wait for pads with gaps only: which pads they wait for, and the message to the user.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "becomes.hpp"
#include "core/sync/collector.hpp"

namespace weir::sync {
namespace gap_wait_test {

using Ids = std::vector<QueueId>;

struct Two {
  Two() {
    queues.add(1);
    queues.add(2);
  }
  void head(QueueId id, Stamp time) { queues.put(id, 0, time, OnBackwardsTime::Pass); }
  Ids waited_for(Mode mode) { return queues.gap_only_queues(mode, 1); }

  Ledger ledger;
  InputQueues<int> queues{&ledger};
};

TEST(WaitForGapOnlyPads, IsAFrameWithATimeBeforeTheGaps) {
  for (const Mode mode : {Mode::NoSync, Mode::BasePad}) {
    Two two;
    two.head(1, 30);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << "nothing is known of the other";
    two.queues.gap(2, 30);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << "a frame of its time may come";
    two.queues.gap(2, 31);
    EXPECT_EQ(two.waited_for(mode), Ids{2});
    EXPECT_EQ(two.queues.step({mode, {}, {}})->outcome, Outcome::Wait) << to_string(mode);
    two.queues.add(3);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << "another is waited for, which brought nothing yet";
    two.queues.gap(3, 99);
    EXPECT_EQ(two.waited_for(mode), (Ids{2, 3}));
  }
}

TEST(WaitForGapOnlyPads, IsNoneIfThePolicyContinuesOnGaps) {
  for (const Mode mode : {Mode::Slowest, Mode::Refresh, Mode::Lateness}) {
    Two two;
    two.head(1, 30);
    two.queues.gap(2, 99);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << to_string(mode);
    EXPECT_TRUE(two.queues.step({mode, {}, {}})->changed) << to_string(mode);
  }
  Two two;  // basepad repeats the frame from before the gap
  two.head(1, 30);
  two.head(2, 30);
  EXPECT_EQ(two.queues.step({Mode::BasePad, {}, {}})->outcome, Outcome::Emit);
  two.head(1, 40);
  two.queues.gap(2, 99);
  EXPECT_EQ(two.waited_for(Mode::NoSync), Ids{2});
  EXPECT_EQ(two.waited_for(Mode::BasePad), Ids{});
  EXPECT_EQ(two.queues.step({Mode::BasePad, {}, {}})->outcome, Outcome::Emit);
}

struct Listener : Consumer<int> {
  int emit(Emission<int> emission) override {
    rows.push_back(std::move(emission.frames));
    return kOk;
  }
  void end() override {}
  void refused(const Error&) override {}
  Status may_wait(QueueId, const std::vector<QueueId>&) override { return ok(); }
  void waits_for_gap_only_pads(QueueId waiting, const Ids& gaps) override {
    reported.set_value({waiting, gaps});  // throws on a second call
  }
  bool waits_for_silent_pads(QueueId waiting, const Ids& silent) override {
    if (++asked <= not_reported) return false;
    reported.set_value({waiting, silent});  // likewise
    return true;
  }

  std::vector<std::vector<int>> rows;
  std::promise<std::pair<QueueId, Ids>> reported;
  int not_reported = 0;       // how often waits_for_silent_pads() returns false
  std::atomic<int> asked{0};  // how often it was called
};

TEST(WaitForGapOnlyPads, AreReportedOnceAndStillWaitedFor) {
  for (const Mode mode : {Mode::NoSync, Mode::BasePad}) {
    Ledger ledger;
    Listener out;
    Collector<int> collector(&ledger, &out, std::chrono::milliseconds(1));
    collector.configure({mode, {}, {}}, OnBackwardsTime::Pass, {});
    collector.start();
    const QueueId a = collector.add(), b = collector.add();
    auto offered = std::async(std::launch::async, [&] { return collector.offer(a, 1, 30); });
    EXPECT_TRUE(becomes_true([&] { return collector.waiting() > 0; }, "a frame that waits"));
    for (const Time end : {20, 40, 60}) collector.gap(b, end);
    EXPECT_EQ(out.reported.get_future().get(), (std::pair{a, Ids{b}})) << to_string(mode);
    EXPECT_TRUE(out.rows.empty());
    EXPECT_EQ(collector.offer(b, 2, 70), kOk);
    EXPECT_EQ(offered.get(), kOk);
    EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1, 2}})) << to_string(mode);
    auto next = std::async(std::launch::async, [&] { return collector.offer(a, 3, 80); });
    EXPECT_TRUE(becomes_true([&] { return collector.waiting() > 0; }, "a frame that waits"));
    collector.gap(b, 90);
    collector.stop();
    EXPECT_NE(next.get(), kOk);
  }
}

TEST(WaitForSilentPads, IsReportedOnceAndTheWaitGoesOn) {
  for (const Mode mode : {Mode::Slowest, Mode::NoSync, Mode::BasePad}) {
    Ledger ledger;
    Listener out;
    out.not_reported = 2;  // as while the element is paused
    Collector<int> collector(&ledger, &out, kGapTimeout, std::chrono::milliseconds(1));
    collector.configure({mode, {}, {}}, OnBackwardsTime::Pass, {});
    collector.start();
    const QueueId a = collector.add(), b = collector.add();
    auto offered = std::async(std::launch::async, [&] { return collector.offer(a, 1, 30); });
    EXPECT_EQ(out.reported.get_future().get(), (std::pair{a, Ids{b}})) << to_string(mode);
    EXPECT_TRUE(out.rows.empty());
    EXPECT_EQ(collector.offer(b, 2, 30), kOk);
    EXPECT_EQ(offered.get(), kOk);
    EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1, 2}})) << to_string(mode);
    auto next = std::async(std::launch::async, [&] { return collector.offer(a, 3, 80); });
    EXPECT_TRUE(becomes_true([&] { return collector.waiting() > 0; }, "a frame that waits"));
    collector.end(b);
    next.get();
    EXPECT_EQ(out.asked, 3) << "a second report";
  }
}

TEST(WaitForSilentPads, IsNotReportedWhereAFrameArrivesInTime) {
  Ledger ledger;
  Listener out;
  Collector<int> collector(&ledger, &out, kGapTimeout, std::chrono::hours(1));
  collector.configure({Mode::Slowest, {}, {}}, OnBackwardsTime::Pass, {});
  collector.start();
  const QueueId a = collector.add(), b = collector.add();
  auto offered = std::async(std::launch::async, [&] { return collector.offer(a, 1, 30); });
  EXPECT_TRUE(becomes_true([&] { return collector.waiting() > 0; }, "a frame that waits"));
  EXPECT_EQ(collector.offer(b, 2, 30), kOk);
  EXPECT_EQ(offered.get(), kOk);
  EXPECT_EQ(out.asked, 0);
}

}  // namespace gap_wait_test
}  // namespace weir::sync
