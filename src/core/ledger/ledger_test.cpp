// The ledger's invariant: every received frame is accounted for.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/ledger/ledger.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace weir {
namespace ledger_test {

TEST(Ledger, StartsEmpty) {
  const LedgerSnapshot s = Ledger().snapshot();
  EXPECT_EQ(s.received, 0u);
  EXPECT_EQ(s.held(), 0u);
}

TEST(Ledger, HeldIsWhatIsNeitherConsumedNorDropped) {
  Ledger ledger;
  for (int i = 0; i < 10; ++i) ledger.received();
  for (int i = 0; i < 4; ++i) ledger.consumed_and_pushed();
  ledger.dropped(DropReason::Qos, 3);
  ledger.dropped(DropReason::Flush);
  const LedgerSnapshot s = ledger.snapshot();
  EXPECT_EQ(s.held(), 2u);
  EXPECT_EQ(s.dropped_total(), 4u);
  EXPECT_EQ(s.pushed, 4u);
}

TEST(Ledger, FramesThatAreLostWithTheirOutputAreNotConsumed) {
  Ledger ledger;
  for (int i = 0; i < 3; ++i) ledger.received();
  ledger.consumed(3);
  ledger.lost(DropReason::Error, 2);
  const auto all = ledger.snapshot();
  EXPECT_EQ(all.consumed, 1u);
  EXPECT_EQ(all.dropped[static_cast<size_t>(DropReason::Error)], 2u);
  EXPECT_EQ(all.held(), 0u);
}

TEST(Ledger, LosesNothingUnderThreads) {
  Ledger ledger;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&ledger] {
      for (int i = 0; i < 1000; ++i) {
        ledger.received();
        ledger.consumed();
      }
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(ledger.snapshot().received, 4000u);
  EXPECT_EQ(ledger.snapshot().held(), 0u);
}

TEST(Ledger, EveryReasonHasItsOwnName) {
  EXPECT_EQ(to_string(DropReason::Policy), "policy");
  EXPECT_EQ(to_string(DropReason::Error), "error");
  EXPECT_NE(to_string(DropReason::Eos), to_string(DropReason::Flush));
}

}  // namespace ledger_test
}  // namespace weir
