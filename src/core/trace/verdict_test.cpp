// One sentence for each kind of run.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/verdict.hpp"

#include <gtest/gtest.h>

namespace weir::trace {
namespace verdict_test {

Load source(double work, Waits waits = Waits::Never, double waiting = 0) {
  return {"source", work, waiting, waits, true, false, 0, 100};
}
Load filter(const std::string& name, double work) {
  return {name, work, 0, Waits::Never, false, false, 100, 100};
}
Load sink(double work, Waits waits = Waits::Start, double waiting = 0) {
  return {"sink", work, waiting, waits, false, true, 100, 0};
}

std::string text(const std::vector<Load>& loads) {
  return judge(loads, {}).text;
}

TEST(TraceVerdict, OneElementThatTakesMostOfTheTimeIsTheBottleneck) {
  const Verdict verdict =
      judge({source(0.05), filter("scale", 0.06), filter("yolox", 0.871), sink(0.01)}, {});
  EXPECT_EQ(verdict.kind, VerdictKind::Bottleneck);
  EXPECT_EQ(verdict.element, "yolox");
  EXPECT_DOUBLE_EQ(verdict.share, 0.871);
  EXPECT_EQ(verdict.text, "yolox takes 87 % of the time: the bottleneck.");
}

TEST(TraceVerdict, ASourceOrASinkCanBeIt) {
  const Verdict reads = judge({source(0.7), filter("a", 0.2), sink(0.1)}, {});
  EXPECT_EQ(reads.kind, VerdictKind::SourceBound);
  EXPECT_EQ(reads.text, "The source source takes 70 % of the time: the bottleneck.");
  const Verdict writes = judge({source(0.1), filter("a", 0.2), sink(0.65)}, {});
  EXPECT_EQ(writes.kind, VerdictKind::SinkBound);
  EXPECT_EQ(writes.text, "The sink sink takes 65 % of the time: the bottleneck.");
}

TEST(TraceVerdict, ABalancedPipelineNamesTheBusiestThree) {
  EXPECT_EQ(text({source(0.1), filter("a", 0.2), filter("b", 0.45), filter("c", 0.23), sink(0)}),
            "No element takes most of the time; the busiest: b 45 %, c 23 %, a 20 %.");
  EXPECT_EQ(text({source(0), sink(0)}), "No element takes a measurable time.");
}

TEST(TraceVerdict, APipelineThatWaitsForALiveSourceKeepsUp) {
  const Verdict verdict =
      judge({source(0.02, Waits::Device, 0.6), filter("yolox", 0.37), sink(0)}, {});
  EXPECT_EQ(verdict.kind, VerdictKind::KeepsUp);
  EXPECT_EQ(
      verdict.text,
      "The pipeline keeps up with its live source source, for which it waits 60 % of the time. "
      "The busiest element is yolox with 37 %.");
}

TEST(TraceVerdict, APipelineThatWaitsForTheClockKeepsUp) {
  const Verdict verdict =
      judge({source(0.1), filter("a", 0.05), sink(0.01, Waits::Clock, 0.84)}, {});
  EXPECT_EQ(verdict.kind, VerdictKind::KeepsUp);
  EXPECT_EQ(verdict.text,
            "The pipeline keeps up with real time: sink waits for the clock 84 % of the time. "
            "The busiest element is source with 10 %.");
}

TEST(TraceVerdict, ALiveSourceThatWaitsDoesNotHideASaturatedFilterInAnotherThread) {
  const std::vector<Load> loads{source(0.01, Waits::Device, 0.98), filter("yolox", 0.97),
                                sink(0.01)};
  EXPECT_EQ(text(loads), "yolox takes 97 % of the time: the bottleneck.");
}

TEST(TraceVerdict, WaitingForRoomOrInputsDoesNotKeepUpWithAnything) {
  for (const Waits waits : {Waits::Room, Waits::Inputs, Waits::Start}) {
    Load queue = filter("queue", 0);
    queue.waits = waits;
    queue.waiting = 0.9;
    EXPECT_EQ(judge({source(0.1), queue, filter("a", 0.55), sink(0)}, {}).kind,
              VerdictKind::Bottleneck);
  }
}

TEST(TraceVerdict, WithoutAFrameAtASinkTheElementWhereFramesEndIsNamed) {
  Load swallows = filter("rate", 0.9);
  swallows.out = 0;
  Load idle = sink(0);
  idle.in = 0;
  const Verdict ends = judge({source(0.1), swallows, idle}, {});
  EXPECT_EQ(ends.kind, VerdictKind::NothingRan);
  EXPECT_EQ(ends.text, "No frame reached a sink: rate received 100 frames and pushed none.");
  Load silent = source(0);
  silent.out = 0;
  EXPECT_EQ(text({silent, idle}), "No frame reached a sink: the source source pushed none.");
  EXPECT_EQ(text({}), "No frame reached a sink.");
}

TEST(TraceVerdict, AFailureComesFirst) {
  const std::vector<Load> loads{source(0.9), sink(0.1)};
  const Verdict verdict = judge(loads, {{"cast", "the option is unknown"}, {"source", "stopped"}});
  EXPECT_EQ(verdict.kind, VerdictKind::Failed);
  EXPECT_EQ(verdict.element, "cast");
  EXPECT_EQ(verdict.text, "cast failed: the option is unknown.");
  EXPECT_EQ(judge(loads, {{"", "no element posted an error."}}).text,
            "The pipeline failed: no element posted an error.");
}

TEST(TraceVerdict, EachKindHasAName) {
  EXPECT_EQ(to_string(VerdictKind::Failed), "failed");
  EXPECT_EQ(to_string(VerdictKind::KeepsUp), "keeps-up");
  EXPECT_EQ(to_string(VerdictKind::Balanced), "balanced");
}

}  // namespace verdict_test
}  // namespace weir::trace
