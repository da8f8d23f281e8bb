// When a filter reports a changed latency to the pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/latency_report.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace latency_report_test {

TEST(LatencyReport, AddsAMargin) {
  LatencyReport report;
  EXPECT_EQ(report.update(0), 0u);
  EXPECT_EQ(report.update(1'000'000), 1'050'000u);
  EXPECT_EQ(report.update(10), 11u) << "10.5 is rounded";
}

TEST(LatencyReport, IsOutdatedAboveTheReportedLatency) {
  LatencyReport report;
  report.update(1000);
  EXPECT_FALSE(report.outdated(1000));
  EXPECT_FALSE(report.outdated(1050));
  EXPECT_TRUE(report.outdated(1051));
  EXPECT_FALSE(report.outdated(1051)) << "the pipeline asks once";
  EXPECT_TRUE(report.outdated(1200)) << "and again when it grew further";
}

TEST(LatencyReport, IsOutdatedMoreThanAQuarterBelow) {
  LatencyReport report;
  EXPECT_EQ(report.update(1000), 1050u);
  EXPECT_FALSE(report.outdated(788)) << "1050 - 788 is 24.95 %";
  EXPECT_TRUE(report.outdated(787)) << "25.05 %";
  EXPECT_FALSE(report.outdated(787));
  EXPECT_EQ(report.update(400), 420u);
  EXPECT_FALSE(report.outdated(315)) << "exactly a quarter";
  EXPECT_TRUE(report.outdated(314));
}

TEST(LatencyReport, IsOutdatedByTheFirstInvoke) {
  LatencyReport report;
  EXPECT_FALSE(report.outdated(0));
  EXPECT_TRUE(report.outdated(1));
  report.reset();
  EXPECT_TRUE(report.outdated(1));
}

TEST(LatencyReport, HandlesAnyNumber) {
  LatencyReport report;
  EXPECT_GT(report.update(UINT64_MAX), UINT64_MAX / 128);
  EXPECT_FALSE(report.outdated(UINT64_MAX));
  EXPECT_TRUE(report.outdated(0));
}

}  // namespace latency_report_test
}  // namespace weir
