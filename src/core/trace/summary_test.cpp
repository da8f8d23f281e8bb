// Compares totals of hand-made records with expected values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/summary.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/trace/trace_test_support.hpp"

namespace weir::trace {
namespace summary_test {

constexpr size_t kSource = 0, kMiddle = 1, kSink = 2;

// The middle element works from 100 to 130 and from 180 to 200, the sink in between.
ThreadRecords one_frame(int64_t start, int64_t time_stamp) {
  return {"t",
          1,
          0,
          {push(start, 12, time_stamp, 7), push(start + 30, 22, time_stamp, 28),
           pushed(start + 80, 22), pushed(start + 100, 12)}};
}

TEST(TraceSummary, TimeInsideDownstreamBelongsToIt) {
  const Trace trace{chain_of_three(), {one_frame(100, 5)}};
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kMiddle].work, 50);
  EXPECT_EQ(summary.elements[kMiddle].longest, 50);
  EXPECT_EQ(summary.elements[kSink].work, 50);
  EXPECT_EQ(summary.elements[kSource].work, 0);
  EXPECT_EQ(summary.begin, 100);
  EXPECT_EQ(summary.end, 200);
  EXPECT_EQ(summary.records, 4u);
}

TEST(TraceSummary, ASourcesTimeIsBetweenItsPushes) {
  Trace trace{chain_of_three(), {one_frame(100, 5)}};
  const auto second = one_frame(270, 6).records;
  auto& records = trace.threads[0].records;
  records.insert(records.end(), second.begin(), second.end());
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kSource].thread_work, 70);
  EXPECT_EQ(summary.elements[kMiddle].thread_work, 0);
  EXPECT_EQ(summary.elements[kMiddle].work, 100);
}

TEST(TraceSummary, CountsFramesBytesAndRatesPerLink) {
  Trace trace{chain_of_three(), {}};
  ThreadRecords thread;
  for (int64_t i = 0; i < 11; ++i) {  // one every 100 ms
    const auto frame = one_frame(i * 100'000'000, i).records;
    thread.records.insert(thread.records.end(), frame.begin(), frame.end());
  }
  trace.threads.push_back(thread);
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kSource].out.frames, 11u);
  EXPECT_EQ(summary.elements[kMiddle].in.bytes, 77u);
  EXPECT_EQ(summary.elements[kMiddle].out.bytes, 308u);
  EXPECT_EQ(summary.elements[kSink].in.frames, 11u);
  EXPECT_EQ(summary.elements[kSink].out.frames, 0u);
  ASSERT_EQ(summary.links.size(), 2u);
  for (const auto& link : summary.links) {
    EXPECT_EQ(link.flow.frames, 11u);
    EXPECT_DOUBLE_EQ(link.flow.rate(), 10.0);
  }
}

TEST(TraceSummary, ALinkThatWasUndoneCountsIfFramesPassed) {
  for (const bool used : {false, true}) {
    Graph graph = chain_of_three();
    add_element(&graph, 40, "other", true, false);
    graph.unlink(at(12), at(21), 150);
    graph.link(at(12), at(41), 160);
    Trace trace{graph, {{"t", 1, 0, {push(200, 12), pushed(210, 12)}}}};
    if (used)
      trace.threads[0].records.insert(trace.threads[0].records.begin(),
                                      {push(100, 12), pushed(110, 12)});
    const Summary summary = summarise(trace);
    std::vector<std::string> ends;
    for (const auto& link : summary.links) {
      ends.push_back(graph.elements()[graph.owner(link.sink_pad)].name);
      EXPECT_EQ(link.flow.frames, ends.back() == "sink" ? 0u : 1u) << ends.back();
    }
    EXPECT_EQ(ends, used ? (std::vector<std::string>{"middle", "other", "sink"})
                         : (std::vector<std::string>{"other", "sink"}));
  }
}

TEST(TraceSummary, LatencyGoesFromSourcesToTheSinksTheyReach) {
  Graph graph = chain_of_three();
  add_element(&graph, 40, "other source", false, true);
  add_element(&graph, 50, "other sink", true, false);
  graph.link(at(42), at(51), 0);
  const Trace trace{graph, {one_frame(100, 5)}};
  const Summary summary = summarise(trace);
  ASSERT_EQ(summary.latencies.size(), 2u);
  EXPECT_EQ(summary.latencies[0].source, kSource);
  EXPECT_EQ(summary.latencies[0].sink, kSink);
  EXPECT_EQ(summary.latencies[0].latency.median, 30);
  EXPECT_EQ(summary.latencies[1].latency.frames, 0u);
}

TEST(TraceSummary, QueuesHaveLevelsAndCountFramesThatNeverLeft) {
  // Three frames arrive on one thread and one leaves on another; a sample shows that one leaked.
  ThreadRecords front{"front", 1, 0, {}}, back{"back", 2, 0, {}};
  for (const int64_t time : {10, 20, 30}) {
    front.records.push_back(push(time, 12));
    front.records.push_back(pushed(time + 1, 12));
  }
  front.records.push_back(record(Kind::Level, 32, 20, 2, 666));
  back.records = {push(40, 22), pushed(45, 22)};
  const Summary summary = summarise({chain_of_three(), {front, back}});
  ASSERT_EQ(summary.queues.size(), 1u);
  const QueueSummary& queue = summary.queues[0];
  EXPECT_EQ(queue.element, kMiddle);
  EXPECT_EQ(queue.level.max, 3u);
  EXPECT_EQ(queue.level.steps.back().frames, 1u);
  EXPECT_EQ(queue.fullest, 666u);
  EXPECT_EQ(queue.not_passed_on, 2u);
}

TEST(TraceSummary, RejectedFramesAreCountedAtTheirPusher) {
  ThreadRecords thread = one_frame(100, 5);
  thread.records[2].value = -5;
  const Summary summary = summarise({chain_of_three(), {thread}});
  EXPECT_EQ(summary.elements[kMiddle].refused, 1u);
  EXPECT_EQ(summary.elements[kSource].refused, 0u);
  EXPECT_EQ(summary.elements[kSink].in.frames, 1u);
}

TEST(TraceSummary, PulledFramesFlowAgainstTheCall) {
  ThreadRecords thread{
      "t",
      1,
      0,
      {record(Kind::PullBegin, 10, 21, kNoTime), record(Kind::PullEnd, 35, 21, 0, 1, 4096),
       record(Kind::PullBegin, 40, 21, kNoTime), record(Kind::PullEnd, 41, 21, -3)}};
  const Summary summary = summarise({chain_of_three(), {thread}});
  EXPECT_EQ(summary.elements[kSource].work, 26);
  EXPECT_EQ(summary.elements[kSource].out.frames, 1u);
  EXPECT_EQ(summary.elements[kMiddle].in.bytes, 4096u);
  EXPECT_EQ(summary.links[0].flow.frames, 1u);
}

TEST(TraceSummary, EventsAndStateChangesAreNotProcessingTime) {
  ThreadRecords thread{
      "t",
      1,
      0,
      {named(Kind::StateBegin, 0, 20, "NULL->READY"), record(Kind::StateEnd, 9, 20),
       named(Kind::EventBegin, 10, 12, "caps"), named(Kind::EventBegin, 12, 22, "caps"),
       record(Kind::EventEnd, 15, 22), record(Kind::EventEnd, 20, 12)}};
  const Summary summary = summarise({chain_of_three(), {thread}});
  EXPECT_EQ(summary.elements[kMiddle].states, 9);
  EXPECT_EQ(summary.elements[kMiddle].events, 7);
  EXPECT_EQ(summary.elements[kSink].events, 3);
  EXPECT_EQ(summary.elements[kMiddle].work, 0);
}

Record thread_time(int64_t time) {
  return record(Kind::ThreadTime, 0, 0, time);
}

// Two frames: source ! middle ! sink. Of 100 in the sink, the thread runs for 10.
ThreadRecords two_timed_frames() {
  ThreadRecords thread{"t", 1, 0, {}};
  for (const int64_t start : {1000, 2000})
    for (const Record& next :
         {push(start, 12), thread_time(start + 5), push(start + 50, 22), thread_time(start + 15),
          pushed(start + 150, 22), pushed(start + 170, 12)})
      thread.records.push_back(next);
  return thread;
}

TEST(TraceSummary, TheTimeThatASinkWaitsForTheClockIsNotWork) {
  Trace trace{chain_of_three(), {two_timed_frames()}};
  trace.graph.set_waits(at(30), Waits::Clock);
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kSink].work, 20);
  EXPECT_EQ(summary.elements[kSink].waiting, 180);
  EXPECT_EQ(summary.elements[kSink].longest, 100);
  EXPECT_EQ(summary.elements[kMiddle].work, 2 * 70);
  EXPECT_EQ(summary.elements[kMiddle].waiting, 0);
  EXPECT_EQ(summary.flow_begin, 1000);
  EXPECT_EQ(summary.flow_end, 2170);
}

TEST(TraceSummary, OtherElementsWaitOnlyWithTheirFirstFrame) {
  const Trace trace{chain_of_three(), {two_timed_frames()}};
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kSink].waiting, 90);
  EXPECT_EQ(summary.elements[kSink].work, 10 + 100);
}

TEST(TraceSummary, AQueueWaitsAllTheTime) {
  Trace trace{chain_of_three(), {one_frame(100, 5)}};
  trace.graph.set_waits(at(20), Waits::Room);
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kMiddle].work, 0);
  EXPECT_EQ(summary.elements[kMiddle].waiting, 50);
}

TEST(TraceSummary, ALiveSourceWaitsBetweenItsPushes) {
  Trace trace{chain_of_three(),
              {{"t",
                1,
                0,
                {thread_time(7), push(100, 12), thread_time(9), pushed(110, 12), thread_time(19),
                 push(150, 12), thread_time(25), pushed(160, 12)}}}};
  trace.graph.set_waits(at(10), Waits::Device);
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kSource].thread_work, 10);
  EXPECT_EQ(summary.elements[kSource].thread_waiting, 30);
}

TEST(TraceSummary, AThreadTimeWithoutItsPartnerMeasuresNothing) {
  Trace trace{chain_of_three(),
              {{"t", 1, 0, {thread_time(5), push(100, 22), pushed(200, 22), thread_time(9)}}}};
  trace.graph.set_waits(at(30), Waits::Clock);
  const Summary summary = summarise(trace);
  EXPECT_EQ(summary.elements[kSink].work, 100);
  EXPECT_EQ(summary.elements[kSink].waiting, 0);
}

TEST(TraceSummary, LinksHaveTheLastCapsOfTheirSourcePad) {
  Graph graph = chain_of_three();
  graph.set_caps(at(12), "video/x-raw, width=8");
  graph.set_caps(at(12), "video/x-raw, width=8");
  graph.set_caps(at(12), "video/x-raw, width=16");
  graph.set_caps(at(99), "of a pad that was never seen");
  graph.removed(at(20));
  const Trace trace{graph, {one_frame(100, 5)}};
  const auto json = nlohmann::json::parse(to_json(summarise(trace), trace));
  EXPECT_EQ(json["links"][0]["caps"], "video/x-raw, width=16");
  EXPECT_EQ(json["links"][0]["caps_changes"], 1);
  EXPECT_EQ(json["links"][1]["caps"], "");
  EXPECT_EQ(json["elements"][kMiddle]["removed"], true);
  EXPECT_EQ(json["elements"][kSink]["removed"], false);
}

TEST(TraceSummary, UnmatchedRecordsDoNotAffectTheRest) {
  ThreadRecords thread = one_frame(100, 5);
  thread.records.insert(thread.records.begin(), pushed(50, 99));
  // The inner end is missing, so the inner span ends with the outer one.
  thread.records.erase(thread.records.begin() + 3);
  thread.records.push_back(push(300, 12, 6));
  thread.records.push_back(push(310, 22, 6));
  const Summary summary = summarise({chain_of_three(), {thread}});
  EXPECT_EQ(summary.elements[kMiddle].work, 30 + 10);
  EXPECT_EQ(summary.elements[kSink].work, 70);
  EXPECT_EQ(summary.elements[kSource].out.frames, 2u);
}

TEST(TraceSummary, UnknownPadsAndPadsWithoutPeersAddNoTime) {
  Graph graph;
  add_element(&graph, 10, "lonely", false, true);
  ThreadRecords thread{"t", 1, 0, {push(1, 12), pushed(2, 12, -1), push(3, 77), pushed(4, 77)}};
  const Summary summary = summarise({graph, {thread}});
  EXPECT_EQ(summary.elements[0].out.frames, 1u);
  EXPECT_EQ(summary.elements[0].refused, 1u);
  EXPECT_TRUE(summary.links.empty());
  EXPECT_TRUE(summarise({}).elements.empty());
}

TEST(TraceSummary, JsonHasTheSumsAndAnyName) {
  Graph graph = chain_of_three();
  graph.name_element(at(20), nullptr, "<b>\"\xff\"", "identity", false, 0);
  const Trace trace{graph, {one_frame(100, 5)}};
  const auto json = nlohmann::json::parse(to_json(summarise(trace), trace));
  EXPECT_EQ(json["elements"][kMiddle]["name"], "<b>\"\xEF\xBF\xBD\"");
  EXPECT_DOUBLE_EQ(json["elements"][kMiddle]["work"].get<double>(), 50e-9);
  EXPECT_EQ(json["links"][0]["from"], kSource);
  EXPECT_EQ(json["links"][0]["to_pad"], "sink");
  EXPECT_EQ(json["latencies"][0]["buckets"][0]["frames"], 1);
  EXPECT_EQ(json["threads"][0]["records"], 4);
  EXPECT_TRUE(json["elements"][kSink]["parent"].is_null());
  EXPECT_TRUE(json["queues"].empty());
}

}  // namespace summary_test
}  // namespace weir::trace
