// Compares the throttle with a plain model of docs/compatibility/filter.md 4.7 and fixed examples.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/throttle.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace weir {
namespace throttle_test {

constexpr uint64_t kMs = 1'000'000;
using Overflow = Throttle::Overflow;

// The accepted ones of `count` frames, one every `step`.
std::vector<int> taken(Throttle& throttle, int count, uint64_t step, uint64_t latency = 0) {
  std::vector<int> out;
  for (int i = 0; i < count; ++i)
    if (!throttle.refuses(static_cast<uint64_t>(i) * step, step, latency)) out.push_back(i);
  return out;
}

TEST(Throttle, AcceptsEveryFrameWithoutALimit) {
  Throttle throttle;
  EXPECT_FALSE(throttle.limited());
  EXPECT_EQ(taken(throttle, 4, kMs, 100 * kMs), (std::vector<int>{0, 1, 2, 3}))
      << "a slow model without a throttle drops nothing";
}

TEST(Throttle, AcceptsOneFramePerDelay) {
  Throttle throttle;
  throttle.limit(199 * kMs);
  EXPECT_TRUE(throttle.limited());
  EXPECT_EQ(taken(throttle, 7, 100 * kMs), (std::vector<int>{0, 2, 4, 6}));
}

TEST(Throttle, AcceptsAFrameAtExactlyTheDelay) {
  Throttle throttle;
  throttle.limit(200 * kMs);
  EXPECT_EQ(taken(throttle, 7, 100 * kMs), (std::vector<int>{0, 2, 4, 6}));
}

TEST(Throttle, WaitsForTheModelWhereItIsSlower) {
  Throttle throttle;
  throttle.limit(200 * kMs);
  EXPECT_EQ(taken(throttle, 7, 100 * kMs, 300 * kMs), (std::vector<int>{0, 3, 6}));
}

TEST(Throttle, ReportsHowMuchTooEarlyAFrameIs) {
  Throttle throttle;
  throttle.limit(200 * kMs);
  EXPECT_FALSE(throttle.refuses(0, 50 * kMs, 0));
  EXPECT_EQ(throttle.refuses(50 * kMs, 50 * kMs, 0), (Overflow{0.25, -150 * int64_t{kMs}}));
  EXPECT_EQ(throttle.refuses(150 * kMs, std::nullopt, 0), (Overflow{0.5, -50 * int64_t{kMs}}))
      << "the distance stands for a duration that is not known";
  EXPECT_EQ(throttle.refuses(210 * kMs, 50 * kMs, 500 * kMs), (Overflow{0.25, 10 * int64_t{kMs}}))
      << "the model is what it waits for";
}

TEST(Throttle, KeepsTheLeastLimit) {
  Throttle throttle;
  throttle.limit(300 * kMs);
  throttle.limit(200 * kMs);
  throttle.limit(400 * kMs);
  EXPECT_EQ(taken(throttle, 7, 100 * kMs), (std::vector<int>{0, 2, 4, 6}));
}

TEST(Throttle, CountsFromTheFrameBeforeTheLimitCame) {
  Throttle throttle;
  EXPECT_FALSE(throttle.refuses(0, {}, 0));
  throttle.limit(200 * kMs);
  EXPECT_TRUE(throttle.refuses(100 * kMs, {}, 0));
  EXPECT_FALSE(throttle.refuses(200 * kMs, {}, 0));
}

TEST(Throttle, IgnoresTimeThatGoesBackwards) {
  Throttle throttle;
  throttle.limit(200 * kMs);
  EXPECT_FALSE(throttle.refuses(1000 * kMs, {}, 0));
  EXPECT_TRUE(throttle.refuses(1100 * kMs, {}, 0));
  EXPECT_TRUE(throttle.refuses(0, {}, 0));
  EXPECT_FALSE(throttle.refuses(100 * kMs, {}, 0));
}

TEST(Throttle, AcceptsTheNextFrameAfterARestartAndKeepsTheLimit) {
  Throttle throttle;
  throttle.limit(200 * kMs);
  EXPECT_FALSE(throttle.refuses(0, {}, 0));
  throttle.restart();
  EXPECT_FALSE(throttle.refuses(1, {}, 0));
  EXPECT_TRUE(throttle.refuses(2, {}, 0));
  throttle.reset();
  EXPECT_EQ(taken(throttle, 3, 1), (std::vector<int>{0, 1, 2}));
}

TEST(Throttle, HandlesMissingTimes) {
  constexpr uint64_t kEnd = std::numeric_limits<uint64_t>::max();
  Throttle throttle;
  throttle.limit(kEnd);
  EXPECT_FALSE(throttle.refuses(0, {}, 0));
  EXPECT_FALSE(throttle.refuses(kEnd, kEnd, 0)) << "as long as any delay";
  EXPECT_TRUE(throttle.refuses(1, {}, kEnd));
}

// The rules of docs/compatibility/filter.md 4.7, step by step.
TEST(Throttle, AgreesWithAPlainModelOnRandomStreams) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 200; ++round) {
    Throttle throttle;
    uint64_t delay = 0, accumulated = 0, time = random() % kMs, before = time;
    for (int i = 0; i < 100; ++i) {
      if (random() % 20 == 0) {
        const uint64_t received = 1 + random() % (100 * kMs);
        throttle.limit(received);
        delay = delay == 0 ? received : std::min(delay, received);
      }
      const uint64_t latency = random() % 3 == 0 ? random() % (100 * kMs) : 0;
      const auto refused = throttle.refuses(time, 5 * kMs, latency);
      accumulated += time - before;
      const bool drop = i > 0 && delay > 0 && accumulated < std::max(latency, delay);
      ASSERT_EQ(refused.has_value(), drop) << "round " << round << " frame " << i;
      if (drop) {
        EXPECT_DOUBLE_EQ(refused->proportion, 5.0 * kMs / static_cast<double>(delay));
        EXPECT_EQ(refused->difference,
                  static_cast<int64_t>(accumulated) - static_cast<int64_t>(delay));
      } else {
        accumulated = 0;
      }
      before = time;
      time += random() % (30 * kMs);
    }
  }
}

}  // namespace throttle_test
}  // namespace weir
