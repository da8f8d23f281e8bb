// Tests of latencies of a sink and of whole graphs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "core/trace/latency.hpp"
#include "core/trace/record.hpp"
#include "core/trace/trace_test_support.hpp"

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
  EXPECT_EQ(latency.min, 1000);
  EXPECT_EQ(latency.mean, 50500);
  EXPECT_EQ(latency.median, 50000);
  EXPECT_EQ(latency.percentile_95, 95000);
  EXPECT_EQ(latency.percentile_99, 99000);
  EXPECT_EQ(latency.max, 100000);
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
  EXPECT_EQ(trace::latency(departures, {{5, 3500}}).max, 500);
  EXPECT_EQ(trace::latency(departures, {{5, 2500}}).max, 1500);
}

TEST(TraceLatency, UnmatchedFramesAreCountedSeparately) {
  const Departures departures{{kNoTime, 0}, {5, 1000}};
  const Latency latency = trace::latency(departures, {{6, 2000}, {kNoTime, 2000}, {5, 900}});
  EXPECT_EQ(latency.frames, 0u);
  EXPECT_EQ(latency.unmatched, 3u);
  EXPECT_EQ(latency.max, 0);
  EXPECT_TRUE(latency.buckets.empty());
}

// file (10) ! demuxer (20), which has pads for pictures (22) and sound (23), ! a sink each (30, 40)
class DemuxedStreams : public ::testing::Test {
 protected:
  DemuxedStreams() {
    add_element(&graph_, 10, "file", false, true);
    add_element(&graph_, 20, "demuxer", true, true);
    graph_.see_pad(at(23), at(20), "sound", true, 0);
    add_element(&graph_, 30, "screen", true, false);
    add_element(&graph_, 40, "speaker", true, false);
    link(12, 21);
    link(22, 31);
    link(23, 41);
  }
  size_t pad(uintptr_t address) const { return graph_.pad_at(at(address), 1); }
  size_t element(uintptr_t address) const { return graph_.element_at(at(address), 1); }
  void link(uintptr_t source, uintptr_t sink) { links_.emplace_back(pad(source), pad(sink)); }
  std::vector<StreamLatency> measured() const { return stream_latencies(graph_, links_, records_); }

  Graph graph_;
  std::vector<std::pair<size_t, size_t>> links_;
  StreamRecords records_;
};

TEST_F(DemuxedStreams, CountFromThePadOfTheDemuxerThatLeadsToTheSink) {
  for (int64_t i = 0; i < 10; ++i) {  // the same timestamps in both streams
    records_.departures[pad(22)].push_back({i * 100, i * 1000});
    records_.departures[pad(23)].push_back({i * 100, i * 1000 + 500});
    records_.arrivals[element(30)].push_back({i * 100, i * 1000 + 600});
    records_.arrivals[element(40)].push_back({i * 100, i * 1000 + 600});
  }
  const auto found = measured();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].sink, element(30));
  EXPECT_EQ(found[0].origin, pad(22));
  EXPECT_EQ(found[0].latency.median, 600);
  EXPECT_EQ(found[1].sink, element(40));
  EXPECT_EQ(found[1].origin, pad(23));
  EXPECT_EQ(found[1].latency.median, 100);
  for (const auto& stream : found) {
    EXPECT_EQ(stream.source, element(10));
    EXPECT_EQ(stream.latency.frames, 10u);
    EXPECT_EQ(stream.latency.unmatched, 0u);
  }
}

TEST_F(DemuxedStreams, TheFirstBlockOfAFileMayHaveATimeStamp) {
  records_.departures[pad(12)].push_back({0, 0});
  for (int64_t i = 0; i < 10; ++i) {
    records_.departures[pad(22)].push_back({i * 100, i * 1000 + 5000});
    records_.arrivals[element(30)].push_back({i * 100, i * 1000 + 5007});
  }
  const auto found = measured();
  EXPECT_EQ(found[0].origin, pad(22));
  EXPECT_EQ(found[0].latency.max, 7);
}

TEST_F(DemuxedStreams, CountFromTheSourceWhereItHasTheTimeStamps) {
  records_.departures[pad(12)] = {{0, 10}, {1, 20}};
  records_.departures[pad(22)] = {{0, 15}, {1, 25}};
  records_.arrivals[element(30)] = {{0, 18}, {1, 28}};
  const auto found = measured();
  EXPECT_EQ(found[0].origin, pad(12));
  EXPECT_EQ(found[0].latency.median, 8);
}

TEST_F(DemuxedStreams, FramesThatNoPadPushedAreNotMatched) {
  records_.departures[pad(22)] = {{0, 15}};
  records_.departures[pad(23)] = {{7, 15}};
  records_.arrivals[element(30)] = {{7, 18}, {8, 28}};
  const auto found = measured();
  EXPECT_EQ(found[0].origin, pad(12));
  EXPECT_EQ(found[0].latency.frames, 0u);
  EXPECT_EQ(found[0].latency.unmatched, 2u) << "the timestamp 7 is that of another stream";
}

TEST_F(DemuxedStreams, ASinkThatNothingReachesHasNone) {
  links_.erase(links_.begin() + 1);
  const auto found = measured();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].sink, element(40));
}

TEST_F(DemuxedStreams, LinksInACircleEnd) {
  add_element(&graph_, 50, "loop", true, true);
  graph_.see_pad(at(24), at(20), "back", false, 0);
  link(22, 51);
  link(52, 24);
  EXPECT_EQ(measured().size(), 2u);
}

}  // namespace latency_test
}  // namespace weir::trace
