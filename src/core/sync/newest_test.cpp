// The newest item, and how long it is used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/sync/newest.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace weir::sync {
namespace newest_test {

std::shared_ptr<const int> item(int value) {
  return std::make_shared<const int>(value);
}
int value_at(Newest<int>* newest, int64_t time, uint64_t max_apart) {
  const auto held = newest->at(time, max_apart);
  return held ? *held : -1;
}

TEST(Newest, IsUsedUntilTheNextArrives) {
  Newest<int> newest;
  EXPECT_EQ(value_at(&newest, 5, 0), -1);
  newest.push(10, item(1));
  EXPECT_EQ(value_at(&newest, 10, 100), 1);
  EXPECT_EQ(value_at(&newest, 20, 100), 1);
  newest.push(30, item(2));
  newest.push(40, item(3));
  EXPECT_EQ(value_at(&newest, 41, 100), 3);
  const auto counts = newest.counts();
  EXPECT_EQ(counts.used, 2u);
  EXPECT_EQ(counts.replaced, 1u);
  EXPECT_EQ(counts.waiting, 0u);
}

TEST(Newest, PrefersAFrameThatIsNotLater) {
  Newest<int> newest;
  for (int i = 1; i <= 5; ++i) newest.push(10 * i, item(i));
  EXPECT_EQ(value_at(&newest, 5, 100), 1) << "the first of the later ones";
  EXPECT_EQ(value_at(&newest, 29, 100), 2);
  EXPECT_EQ(value_at(&newest, 30, 100), 3);
  EXPECT_EQ(value_at(&newest, 30, 100), 3);
  EXPECT_EQ(newest.counts().waiting, 2u);
  EXPECT_EQ(value_at(&newest, kNoTime, 1), 5) << "without a time the newest of all";
  const auto counts = newest.counts();
  EXPECT_EQ(counts.used, 4u);
  EXPECT_EQ(counts.replaced, 1u);
  EXPECT_EQ(counts.waiting, 0u);
}

TEST(Newest, HoldsALimitedNumberOfEarlyFrames) {
  constexpr int kMany = static_cast<int>(Newest<int>::kMaxHeld) + 3;
  Newest<int> newest;
  for (int i = 0; i < kMany; ++i) newest.push(i, item(i));
  EXPECT_EQ(newest.counts().replaced, 3u);
  EXPECT_EQ(newest.counts().waiting, Newest<int>::kMaxHeld);
  EXPECT_EQ(value_at(&newest, 0, 0), 3);
  EXPECT_EQ(value_at(&newest, kMany, 0), kMany - 1);
}

TEST(Newest, IsTooFarBeyondItsAgeInBothDirections) {
  Newest<int> newest;
  newest.push(1000, item(1));
  EXPECT_EQ(value_at(&newest, 1100, 100), 1);
  EXPECT_EQ(value_at(&newest, 1101, 100), -1);
  EXPECT_EQ(value_at(&newest, 900, 100), 1);
  EXPECT_EQ(value_at(&newest, 899, 100), -1);
  EXPECT_EQ(value_at(&newest, INT64_MAX, 0), 1);
  EXPECT_EQ(value_at(&newest, kNoTime, 100), 1);
  newest.clear();
  newest.push(INT64_MAX, item(2));
  EXPECT_EQ(value_at(&newest, INT64_MIN + 1, UINT64_MAX), 2);
  EXPECT_EQ(value_at(&newest, INT64_MIN + 1, 1), -1);
}

TEST(Newest, WithoutATimeHasThatOfItsFirstUse) {
  Newest<int> newest;
  newest.push(kNoTime, item(1));
  EXPECT_EQ(value_at(&newest, 5000, 100), 1);
  EXPECT_EQ(value_at(&newest, 5100, 100), 1);
  EXPECT_EQ(value_at(&newest, 5101, 100), -1);
}

TEST(Newest, CountsReplacedFrames) {
  Newest<int> newest;
  newest.push(1, item(1));
  EXPECT_EQ(newest.counts().waiting, 1u);
  newest.clear();
  newest.push(2, item(2));
  EXPECT_EQ(value_at(&newest, 2, 0), 2);
  newest.clear();
  EXPECT_EQ(value_at(&newest, 2, 0), -1);
  const auto counts = newest.counts();
  EXPECT_EQ(counts.cleared, 1u);
  EXPECT_EQ(counts.used, 1u);
  EXPECT_EQ(counts.waiting, 0u);
  newest.reset();
  EXPECT_EQ(newest.counts().used, 0u);
}

TEST(Newest, AddsUpWithTwoThreads) {
  constexpr int kMany = 20000;
  Newest<int> newest;
  std::thread bringing([&] {
    for (int i = 0; i < kMany; ++i) newest.push(i, item(i));
  });
  int last = -1;
  while (last < kMany - 1) {
    const int value = value_at(&newest, kNoTime, 0);
    EXPECT_GE(value, last);
    last = value;
  }
  bringing.join();
  const auto counts = newest.counts();
  EXPECT_EQ(counts.used + counts.replaced, static_cast<uint64_t>(kMany));
}

}  // namespace newest_test
}  // namespace weir::sync
