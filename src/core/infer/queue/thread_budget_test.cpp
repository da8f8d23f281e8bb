// Tests the division of cores against values calculated by hand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/thread_budget.hpp"

#include <gtest/gtest.h>

namespace weir::infer {
namespace thread_budget_test {

TEST(ThreadBudget, LeavesTheChoiceToTheEngineOfALoneModel) {
  EXPECT_EQ(split_cores({1, 0}, {}, 8), 0);
}

TEST(ThreadBudget, DividesTheCoresAmongWorkers) {
  EXPECT_EQ(split_cores({2, 0}, {}, 8), 4);
  EXPECT_EQ(split_cores({3, 0}, {}, 8), 2);
  EXPECT_EQ(split_cores({9, 0}, {}, 8), 1) << "never none";
}

TEST(ThreadBudget, DividesTheCoresAmongModels) {
  EXPECT_EQ(split_cores({1, 0}, {{1, 0}}, 8), 4);
  EXPECT_EQ(split_cores({1, 0}, {{2, 0}, {1, 0}}, 8), 2);
}

TEST(ThreadBudget, SubtractsThreadsOfOthers) {
  EXPECT_EQ(split_cores({1, 0}, {{2, 3}}, 8), 2);
  EXPECT_EQ(split_cores({1, 0}, {{1, 100}}, 8), 1);
  EXPECT_EQ(split_cores({2, 0}, {{1, 4}, {1, 0}}, 10), 2);
}

TEST(ThreadBudget, GrantsTheRequestedThreads) {
  EXPECT_EQ(split_cores({4, 5}, {{1, 0}}, 8), 5);
}

TEST(ThreadBudget, ForgetsEndedClaims) {
  ThreadBudget budget(8);
  const auto one = budget.claim({1, 0});
  EXPECT_EQ(budget.count_threads(one), 0);
  {
    const auto two = budget.claim({3, 0});
    EXPECT_EQ(budget.count_threads(one), 2);
    EXPECT_EQ(budget.count_threads(two), 2);
  }
  EXPECT_EQ(budget.count_threads(one), 0);
}

TEST(ThreadBudget, IgnoresAnEmptyClaim) {
  ThreadBudget budget(8);
  EXPECT_EQ(budget.count_threads({}), 0);
}

TEST(ThreadBudget, NeverGrantsMoreThanTheCores) {
  for (int cores = 1; cores <= 32; ++cores)
    for (int models = 1; models <= 8; ++models)
      for (int workers = 1; workers <= 4; ++workers) {
        ThreadBudget budget(cores);
        std::vector<ThreadBudget::Claim> claims;
        for (int i = 0; i < models; ++i) claims.push_back(budget.claim({workers, 0}));
        int sum = 0;
        for (const auto& claim : claims) sum += workers * budget.count_threads(claim);
        EXPECT_LE(sum, std::max(cores, models * workers)) << cores << " " << models;
      }
}

}  // namespace thread_budget_test
}  // namespace weir::infer
