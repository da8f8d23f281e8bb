// Frames that wait behind gaps alone: for whom they wait, and that the user is told.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <future>

#include "becomes.hpp"
#include "core/sync/collector.hpp"

namespace weir::sync {
namespace {

using Ids = std::vector<LaneId>;

struct Two {
  Two() {
    lanes.add(1);
    lanes.add(2);
  }
  void head(LaneId id, Stamp time) { lanes.put(id, 0, time, OnBackwardsTime::Pass); }
  Ids waited_for(Mode mode) { return lanes.waited_for_behind_gaps(mode, 1); }

  Ledger ledger;
  Lanes<int> lanes{&ledger};
};

TEST(BehindGaps, IsAFrameWhoseTimeTheyHavePassed) {
  for (const Mode mode : {Mode::NoSync, Mode::BasePad}) {
    Two two;
    two.head(1, 30);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << "nothing is known of the other";
    two.lanes.gap(2, 30);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << "a frame of its time may come";
    two.lanes.gap(2, 31);
    EXPECT_EQ(two.waited_for(mode), Ids{2});
    EXPECT_EQ(two.lanes.step({mode, {}, {}})->outcome, Outcome::Wait) << name_of(mode);
    two.lanes.add(3);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << "another is waited for, which brought nothing yet";
    two.lanes.gap(3, 99);
    EXPECT_EQ(two.waited_for(mode), (Ids{2, 3}));
  }
}

TEST(BehindGaps, IsNoneWhereAPolicyGoesOnByThem) {
  for (const Mode mode : {Mode::Slowest, Mode::Refresh, Mode::Lateness}) {
    Two two;
    two.head(1, 30);
    two.lanes.gap(2, 99);
    EXPECT_EQ(two.waited_for(mode), Ids{}) << name_of(mode);
    EXPECT_TRUE(two.lanes.step({mode, {}, {}})->changed) << name_of(mode);
  }
  Two two;  // basepad repeats the frame that was there before the gap
  two.head(1, 30);
  two.head(2, 30);
  EXPECT_EQ(two.lanes.step({Mode::BasePad, {}, {}})->outcome, Outcome::Emit);
  two.head(1, 40);
  two.lanes.gap(2, 99);
  EXPECT_EQ(two.waited_for(Mode::NoSync), Ids{2});
  EXPECT_EQ(two.waited_for(Mode::BasePad), Ids{});
  EXPECT_EQ(two.lanes.step({Mode::BasePad, {}, {}})->outcome, Outcome::Emit);
}

struct Listener : Consumer<int> {
  int emit(Emission<int> emission) override {
    rows.push_back(std::move(emission.frames));
    return kOk;
  }
  void end() override {}
  void refused(const Error&) override {}
  Status may_wait(LaneId, const std::vector<LaneId>&) override { return ok(); }
  void waits_behind_gaps(LaneId waiting, const Ids& gaps) override {
    told.set_value({waiting, gaps});  // throws when it is told twice
  }

  std::vector<std::vector<int>> rows;
  std::promise<std::pair<LaneId, Ids>> told;
};

TEST(BehindGaps, AreToldOnceAndWaitedForStill) {
  for (const Mode mode : {Mode::NoSync, Mode::BasePad}) {
    Ledger ledger;
    Listener out;
    Collector<int> collector(&ledger, &out, std::chrono::milliseconds(1));
    collector.configure({mode, {}, {}}, OnBackwardsTime::Pass, {});
    collector.start();
    const LaneId a = collector.add(), b = collector.add();
    auto offered = std::async(std::launch::async, [&] { return collector.offer(a, 1, 30); });
    EXPECT_TRUE(becomes_true([&] { return collector.waiting() > 0; }, "a frame that waits"));
    for (const Time end : {20, 40, 60}) collector.gap(b, end);
    EXPECT_EQ(out.told.get_future().get(), (std::pair{a, Ids{b}})) << name_of(mode);
    EXPECT_TRUE(out.rows.empty());
    EXPECT_EQ(collector.offer(b, 2, 70), kOk);
    EXPECT_EQ(offered.get(), kOk);
    EXPECT_EQ(out.rows, (std::vector<std::vector<int>>{{1, 2}})) << name_of(mode);
    auto next = std::async(std::launch::async, [&] { return collector.offer(a, 3, 80); });
    EXPECT_TRUE(becomes_true([&] { return collector.waiting() > 0; }, "a frame that waits"));
    collector.gap(b, 90);
    collector.stop();
    EXPECT_NE(next.get(), kOk);
  }
}

}  // namespace
}  // namespace weir::sync
