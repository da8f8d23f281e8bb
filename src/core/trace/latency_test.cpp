// Compares latencies with expected values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/latency.hpp"

#include <gtest/gtest.h>

#include "core/trace/record.hpp"

namespace weir::trace {
namespace latency_test {

TEST(TraceLatency, IsArrivalMinusDeparture) {
  // 100 frames with latencies of 1, 2, ... 100 us.
  Departures departures;
  std::vector<Arrival> arrivals;
  for (int64_t i = 1; i <= 100; ++i) {
    departures.push_back({i * 40, i * 1'000'000});
    arrivals.push_back({i * 40, i * 1'000'000 + i * 1000});
  }
  const Latency latency = trace::latency(departures, arrivals);
  EXPECT_EQ(latency.frames, 100u);
  EXPECT_EQ(latency.unmatched, 0u);
  EXPECT_EQ(latency.least, 1000);
  EXPECT_EQ(latency.mean, 50500);
  EXPECT_EQ(latency.median, 50000);
  EXPECT_EQ(latency.percentile_95, 95000);
  EXPECT_EQ(latency.percentile_99, 99000);
  EXPECT_EQ(latency.most, 100000);
}

TEST(TraceLatency, BucketsAreContiguousAndHoldEveryFrame) {
  const Departures departures{{0, 0}, {1, 0}, {2, 0}, {3, 0}};
  const Latency latency = trace::latency(departures, {{0, 999}, {1, 1000}, {2, 1999}, {3, 4000}});
  // Bounds: 0, 1000, 1414, 2000, 2828, 4000, 5657 ns.
  ASSERT_EQ(latency.buckets.size(), 6u);
  const std::vector<uint64_t> frames{1, 1, 1, 0, 0, 1};
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(latency.buckets[i].frames, frames[i]) << i;
    if (i > 0) {
      EXPECT_EQ(latency.buckets[i].from, latency.buckets[i - 1].to);
    }
  }
  EXPECT_EQ(latency.buckets[0].from, 0);
  EXPECT_EQ(latency.buckets[2].from, 1414);
  EXPECT_EQ(latency.buckets[5].from, 4000);
  EXPECT_EQ(latency.buckets[5].to, 5657);
}

TEST(TraceLatency, ARepeatedTimeStampCountsFromItsLastDeparture) {
  const Departures departures{{5, 1000}, {5, 3000}, {5, 9000}};
  EXPECT_EQ(trace::latency(departures, {{5, 3500}}).most, 500);
  EXPECT_EQ(trace::latency(departures, {{5, 2500}}).most, 1500);
}

TEST(TraceLatency, UnmatchedFramesAreCountedSeparately) {
  const Departures departures{{kNoTime, 0}, {5, 1000}};
  const Latency latency = trace::latency(departures, {{6, 2000}, {kNoTime, 2000}, {5, 900}});
  EXPECT_EQ(latency.frames, 0u);
  EXPECT_EQ(latency.unmatched, 3u);
  EXPECT_EQ(latency.most, 0);
  EXPECT_TRUE(latency.buckets.empty());
}

}  // namespace latency_test
}  // namespace weir::trace
