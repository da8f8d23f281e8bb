// Tests each rule of a busy pool, and their invariants over many loads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/busy_policy.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace weir::infer {
namespace busy_policy_test {

BusyDecision of(WhenBusy when_busy, const PoolLoad& load, uint64_t bytes = 1, uint64_t limit = 0) {
  return judge({2, when_busy, limit}, load, bytes);
}

TEST(BusyPolicy, AcceptsFramesWhileAWorkerIsFree) {
  for (const auto when_busy : {WhenBusy::Block, WhenBusy::DropNew, WhenBusy::DropOld}) {
    EXPECT_EQ(of(when_busy, {0, 0, 0, 0}), BusyDecision::Take);
    EXPECT_EQ(of(when_busy, {1, 0, 9, 0}), BusyDecision::Take);
    EXPECT_EQ(of(when_busy, {0, 1, 0, 9}), BusyDecision::Take) << "given, and not begun yet";
  }
}

TEST(BusyPolicy, LetsOneFrameForEachWorkerWaitWhereItBlocks) {
  EXPECT_EQ(of(WhenBusy::Block, {2, 1, 0, 0}), BusyDecision::Take);
  EXPECT_EQ(of(WhenBusy::Block, {2, 2, 0, 0}), BusyDecision::Wait);
}

TEST(BusyPolicy, DropsTheNewWhenEveryWorkerIsBusy) {
  EXPECT_EQ(of(WhenBusy::DropNew, {2, 0, 0, 0}), BusyDecision::DropNew);
  EXPECT_EQ(of(WhenBusy::DropNew, {1, 1, 0, 0}), BusyDecision::DropNew);
}

TEST(BusyPolicy, LetsTheNewestWaitInPlaceOfTheOlder) {
  EXPECT_EQ(of(WhenBusy::DropOld, {2, 0, 0, 0}), BusyDecision::Take);
  EXPECT_EQ(of(WhenBusy::DropOld, {2, 1, 0, 0}), BusyDecision::DropOldest);
}

TEST(BusyPolicy, HoldsNoMoreBytesThanAllowed) {
  EXPECT_EQ(of(WhenBusy::Block, {1, 0, 60, 0}, 40, 100), BusyDecision::Take);
  EXPECT_EQ(of(WhenBusy::Block, {1, 0, 60, 0}, 41, 100), BusyDecision::Wait);
  EXPECT_EQ(of(WhenBusy::DropNew, {1, 0, 60, 0}, 41, 100), BusyDecision::DropNew);
  EXPECT_EQ(of(WhenBusy::DropOld, {1, 1, 30, 60}, 41, 100), BusyDecision::DropOldest);
}

TEST(BusyPolicy, AcceptsAFrameAboveTheBoundWhenItHoldsNothingElse) {
  EXPECT_EQ(of(WhenBusy::Block, {}, 101, 100), BusyDecision::Take);
  EXPECT_EQ(of(WhenBusy::Block, {1, 0, 1, 0}, 101, 100), BusyDecision::Wait);
  EXPECT_EQ(of(WhenBusy::Block, {1, 0, 101, 0}, 1, 100), BusyDecision::Wait);
}

TEST(BusyPolicy, DropsNoWaitingFrameForOneThatCannotBeAccepted) {
  EXPECT_EQ(of(WhenBusy::DropOld, {1, 1, 60, 10}, 50, 100), BusyDecision::DropNew);
  EXPECT_EQ(of(WhenBusy::DropOld, {1, 0, 60, 0}, 50, 100), BusyDecision::DropNew);
}

TEST(BusyPolicy, AddsUpSizesThatDoNotFitANumber) {
  constexpr uint64_t kMax = UINT64_MAX;
  EXPECT_EQ(of(WhenBusy::Block, {1, 0, 10, 0}, kMax, 100), BusyDecision::Wait);
  EXPECT_EQ(of(WhenBusy::Block, {1, 0, kMax, 0}, 1, 100), BusyDecision::Wait);
}

// Frames come and go at random: limits hold, waiting is always allowed, judging again ends.
TEST(BusyPolicy, KeepsItsInvariantsUnderAnyLoad) {
  std::mt19937 random(7);
  const auto below = [&](uint32_t n) { return random() % n; };
  for (int run = 0; run < 300; ++run) {
    const PoolLimits limits{1 + below(4), static_cast<WhenBusy>(below(3)), below(2) ? 100u : 0u};
    std::vector<uint64_t> working, waiting;
    const auto load = [&] {
      PoolLoad out{working.size(), waiting.size(), 0, 0};
      for (const auto b : working) out.working_bytes += b;
      for (const auto b : waiting) out.waiting_bytes += b;
      return out;
    };
    for (int step = 0; step < 200; ++step) {
      if (below(2) && !working.empty()) working.erase(working.begin() + below(working.size()));
      if (working.size() < limits.workers && !waiting.empty()) {
        working.push_back(waiting.front());
        waiting.erase(waiting.begin());
      }
      const uint64_t bytes = 1 + below(120);
      BusyDecision verdict = judge(limits, load(), bytes);
      while (verdict == BusyDecision::DropOldest) {
        ASSERT_FALSE(waiting.empty());
        waiting.erase(waiting.begin());
        verdict = judge(limits, load(), bytes);
        ASSERT_NE(verdict, BusyDecision::DropNew) << "the older one was dropped for nothing";
      }
      const bool blocks = limits.when_busy == WhenBusy::Block;
      ASSERT_NE(verdict, blocks ? BusyDecision::DropNew : BusyDecision::Wait);
      if (verdict == BusyDecision::Take) waiting.push_back(bytes);
      ASSERT_LE(load().working + load().waiting, limits.workers + limits.ahead());
      const uint64_t held = load().working_bytes + load().waiting_bytes;
      if (limits.bytes && working.size() + waiting.size() > 1) {
        ASSERT_LE(held, limits.bytes);
      }
    }
  }
}

}  // namespace busy_policy_test
}  // namespace weir::infer
