// tensor_mux: a pad that only receives GAP events, with policies that need buffers, or nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_mux/many_inputs_test_support.hpp"
#include "says.hpp"

namespace weir::test {
namespace gap_wait_test {

TEST(TensorMuxGaps, AreReportedIfAFrameWaitsForAPadWithOnlyGaps) {
  for (const std::string mode : {"nosync", "basepad"}) {
    ManyInputs mux("tensor_mux sync-mode=" + mode);
    for (int i = 0; i < 2; ++i) mux.add(caps_of_bytes(1).c_str());
    mux.play();
    auto push = mux.push_later(0, Bytes{1}, 30);
    mux.wait_for_stat("received", 1);
    for (GstClockTime time = 0; time < 50; time += 10) mux.event(1, gst_event_new_gap(time, 10));
    std::string warning;
    EXPECT_TRUE(becomes_true([&] { return !(warning = mux.warning()).empty(); },
                             [] { return "a warning"; }));
    EXPECT_SAYS(warning, "WEIR-5001: a frame waits for a pad that has only received GAP events");
    EXPECT_SAYS(warning, "offered: a frame on sink_0, and GAP events past its time on sink_1");
    EXPECT_SAYS(warning, "needed: a frame on sink_1");
    EXPECT_SAYS(warning, "fix: max-wait=");
    EXPECT_EQ(mux.push(1, Bytes{2}, 60), GST_FLOW_OK) << "it kept waiting";
    EXPECT_EQ(push.get(), GST_FLOW_OK);
    EXPECT_EQ(read_memories(mux.buffers().at(0).get()), (std::vector<Bytes>{{1}, {2}})) << mode;
  }
}

// The element warns after 10 seconds, and only while it plays.
TEST(TensorMuxSilence, OfAPadIsAWarning) {
  ManyInputs mux("tensor_mux sync-mode=slowest");
  for (int i = 0; i < 2; ++i) mux.add(caps_of_bytes(1).c_str());
  mux.play();
  auto push = mux.push_later(0, Bytes{1}, 30);
  std::string warning;
  EXPECT_TRUE(
      becomes_true([&] { return !(warning = mux.warning()).empty(); }, [] { return "a warning"; }));
  EXPECT_SAYS(warning, "WEIR-5001: a frame has waited 10 s for a pad that receives nothing");
  EXPECT_SAYS(warning, "offered: a frame on sink_0, and nothing on sink_1");
  EXPECT_SAYS(warning, "needed: a frame on sink_1, or its end");
  EXPECT_SAYS(warning, "fix: max-wait=");
  EXPECT_EQ(mux.push(1, Bytes{2}, 30), GST_FLOW_OK) << "it kept waiting";
  EXPECT_EQ(push.get(), GST_FLOW_OK);
}

}  // namespace gap_wait_test
}  // namespace weir::test
