// Reads the Trace Event Format back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/trace_events.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "core/trace/trace_test_support.hpp"

namespace weir::trace {
namespace trace_events_test {

using Json = nlohmann::json;

Json written(const Trace& trace) {
  std::ostringstream out;
  write_trace_events(trace, out);
  return Json::parse(out.str());
}

std::vector<Json> of_phase(const Json& document, const std::string& phase) {
  std::vector<Json> out;
  for (const auto& event : document["traceEvents"])
    if (event["ph"] == phase) out.push_back(event);
  return out;
}

TEST(TraceEvents, PushesAreCompleteEventsNamedByTheElementTheyGoTo) {
  const Trace trace{chain_of_three(),
                    {{"streaming \"one\"",
                      77,
                      0,
                      {push(5'000'000, 12, 40, 7), push(5'000'250, 22), pushed(5'001'500, 22, -2),
                       pushed(5'002'007, 12)}}}};
  const Json document = written(trace);
  const auto spans = of_phase(document, "X");
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ(spans[0]["name"], "sink");  // it ended first
  EXPECT_EQ(spans[0]["ts"], 0.25);
  EXPECT_EQ(spans[0]["dur"], 1.25);
  EXPECT_EQ(spans[0]["args"]["good"], false);
  EXPECT_FALSE(spans[0]["args"].contains("time_stamp_ns"));
  EXPECT_EQ(spans[1]["name"], "middle");
  EXPECT_EQ(spans[1]["ts"], 0);
  EXPECT_EQ(spans[1]["dur"], 2.007);
  EXPECT_EQ(spans[1]["cat"], "push");
  EXPECT_EQ(spans[1]["tid"], 77);
  EXPECT_EQ(spans[1]["args"], (Json{{"from", "source.src"},
                                    {"frames", 1},
                                    {"bytes", 7},
                                    {"time_stamp_ns", 40},
                                    {"good", true}}));
  const auto names = of_phase(document, "M");
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[1]["args"]["name"], "streaming \"one\"");
}

TEST(TraceEvents, QueuesAreCountersAndEventsHaveNames) {
  const Trace trace{
      chain_of_three(),
      {{"a",
        1,
        0,
        {named(Kind::EventBegin, 10, 12, "eos"), record(Kind::EventEnd, 20, 12),
         named(Kind::StateBegin, 30, 20, "PLAYING->PAUSED"), record(Kind::StateEnd, 40, 20),
         record(Kind::Level, 50, 20, 9), record(Kind::Level, 60, 999, 9)}}}};
  const Json document = written(trace);
  const auto spans = of_phase(document, "X");
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ(spans[0]["args"]["what"], "eos");
  EXPECT_EQ(spans[0]["cat"], "event");
  EXPECT_EQ(spans[1]["args"]["what"], "PLAYING->PAUSED");
  EXPECT_EQ(spans[1]["name"], "middle");
  const auto counters = of_phase(document, "C");
  ASSERT_EQ(counters.size(), 1u);
  EXPECT_EQ(counters[0]["args"]["frames"], 9);
  EXPECT_EQ(counters[0]["ts"], 0.04);
}

TEST(TraceEvents, AnEmptyTraceIsADocument) {
  EXPECT_TRUE(of_phase(written({}), "X").empty());
}

TEST(TraceEvents, InvalidUtf8NamesKeepTheDocumentValid) {
  Graph graph = chain_of_three();
  graph.name_element(at(20), nullptr, "\xff\"</script>", "f", false, 0);
  const auto spans = of_phase(written({graph, {{"", 1, 0, {push(1, 12), pushed(2, 12)}}}}), "X");
  EXPECT_EQ(spans[0]["name"], "\xEF\xBF\xBD\"</script>");
}

}  // namespace trace_events_test
}  // namespace weir::trace
