// Tests invoke statistics against values calculated by hand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/invoke_statistics.hpp"

#include <gtest/gtest.h>

namespace weir::infer {
namespace invoke_statistics_test {

using std::chrono::microseconds;

TEST(InvokeStatistics, IsEmptyBeforeTheFirstInvoke) {
  const InvokeStatistics s;
  EXPECT_EQ(s.snapshot().count, 0u);
  EXPECT_EQ(s.latency_us(), -1);
  EXPECT_EQ(s.throughput_milli(), -1);
}

TEST(InvokeStatistics, CountsLastAndAverage) {
  InvokeStatistics s;
  for (const int us : {100, 200, 600}) s.record(microseconds(us));
  EXPECT_EQ(s.snapshot().count, 3u);
  EXPECT_DOUBLE_EQ(s.snapshot().last_us, 600);
  EXPECT_DOUBLE_EQ(s.snapshot().average_us, 300);
}

TEST(InvokeStatistics, LeavesTheFirstInvokeOutOfLatencyAndThroughput) {
  InvokeStatistics s;
  s.record(microseconds(100000));
  EXPECT_EQ(s.latency_us(), -1);
  s.record(microseconds(1000));
  EXPECT_EQ(s.latency_us(), 1000);
  EXPECT_EQ(s.throughput_milli(), 1000 * 1000) << "1000 a second, times 1000";
}

TEST(InvokeStatistics, AveragesTheLastTenForLatency) {
  InvokeStatistics s;
  for (int us = 1; us <= 21; ++us) s.record(microseconds(us));
  EXPECT_EQ(s.latency_us(), 17) << "12..21 have the mean 16.5";
}

TEST(InvokeStatistics, ForgetsOldInvokesInThroughput) {
  InvokeStatistics s;
  s.record(microseconds(1));
  for (int i = 0; i < 1000; ++i) s.record(microseconds(5000));
  for (int i = 0; i < 2000; ++i) s.record(microseconds(1000));
  EXPECT_EQ(s.throughput_milli(), 1000 * 1000) << "the slow ones are older than 2000 invokes";
}

TEST(InvokeStatistics, BoundsThePercentile) {
  InvokeStatistics s;
  for (int us = 1; us <= 1000; ++us) s.record(microseconds(us));
  EXPECT_GE(s.snapshot().p99_us, 990);
  EXPECT_LE(s.snapshot().p99_us, 990 * 1.13);
}

TEST(InvokeStatistics, HandlesExtremeDurations) {
  InvokeStatistics s;
  s.record(std::chrono::nanoseconds(-5));
  s.record(std::chrono::nanoseconds(0));
  s.record(std::chrono::hours(24 * 365));
  EXPECT_EQ(s.snapshot().count, 3u);
  EXPECT_GT(s.snapshot().p99_us, 1e6);
}

TEST(InvokeStatistics, CanBeReset) {
  InvokeStatistics s;
  s.record(microseconds(5));
  s.reset();
  EXPECT_EQ(s.snapshot().count, 0u);
}

}  // namespace invoke_statistics_test
}  // namespace weir::infer
