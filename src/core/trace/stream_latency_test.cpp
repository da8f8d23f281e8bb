// Latencies from where the timestamps begin.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/stream_latency.hpp"

#include <gtest/gtest.h>

#include "core/trace/trace_test_support.hpp"

namespace weir::trace {
namespace stream_latency_test {

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
  EXPECT_EQ(found[0].latency.most, 7);
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

}  // namespace stream_latency_test
}  // namespace weir::trace
