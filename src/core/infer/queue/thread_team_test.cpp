// Tests jobs distributed over threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/thread_team.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <set>

namespace weir::infer {
namespace thread_team_test {

TEST(ThreadTeam, RunsEachJobOnce) {
  for (const size_t threads : {1, 2, 3, 8}) {
    ThreadTeam team(threads);
    for (size_t count = 0; count < 40; ++count) {
      std::vector<int> done(count);
      team.run(count, [&](size_t thread, size_t number) {
        EXPECT_LT(thread, threads);
        ++done[number];
      });
      EXPECT_EQ(std::ranges::count(done, 1), static_cast<std::ptrdiff_t>(count));
    }
  }
}

TEST(ThreadTeam, WorksOnlyOnTheCallersThread) {
  ThreadTeam team(1);
  const auto self = std::this_thread::get_id();
  std::vector<size_t> order;
  team.run(3, [&](size_t thread, size_t number) {
    EXPECT_EQ(std::this_thread::get_id(), self);
    EXPECT_EQ(thread, 0u);
    order.push_back(number);
  });
  EXPECT_EQ(order, (std::vector<size_t>{0, 1, 2}));
}

// Each job waits for the others: run sequentially they would never end.
TEST(ThreadTeam, RunsAsManyAtOnceAsItHasThreads) {
  ThreadTeam team(3);
  ASSERT_EQ(team.threads(), 3u);
  std::barrier all(3);
  std::mutex mutex;
  std::set<size_t> seen;
  team.run(3, [&](size_t thread, size_t) {
    all.arrive_and_wait();
    const std::lock_guard lock(mutex);
    seen.insert(thread);
  });
  EXPECT_EQ(seen, (std::set<size_t>{0, 1, 2}));
}

}  // namespace thread_team_test
}  // namespace weir::infer
