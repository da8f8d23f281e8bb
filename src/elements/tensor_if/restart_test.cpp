// tensor_if keeps its pads and links while it is stopped.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/branches_test_support.hpp"

namespace weir::test {
namespace restart_test {

TEST(TensorIfRestart, PadsAndLinksRemainInStateNull) {
  Branches way(
      "tensor_if compared-value=A_VALUE compared-value-option=0:0:0:0,0 operator=GT "
      "supplied-value=5 then=PASSTHROUGH else=PASSTHROUGH");
  for (int round = 0; round < 3; ++round) {
    if (round > 0) {
      gst_element_set_state(way.element(), GST_STATE_NULL);
      ASSERT_EQ(gst_element_set_state(way.element(), GST_STATE_PLAYING), GST_STATE_CHANGE_SUCCESS);
      way.send(gst_event_new_stream_start("again"));
      way.branch("src_0").events.clear();
      way.branch("src_1").events.clear();
    }
    way.caps(test::tensors("uint8", "1"));
    if (round > 0) way.send(test::time_segment());
    ASSERT_EQ(way.push(make_frame({{9}})), GST_FLOW_OK);
    ASSERT_EQ(way.push(make_frame({{1}})), GST_FLOW_OK);
    EXPECT_EQ(content(way.take("src_0").get(), 0), Bytes{9});
    EXPECT_EQ(content(way.take("src_1").get(), 0), Bytes{1});
    EXPECT_EQ(way.branch("src_0").events,
              (std::vector<std::string>{"stream-start", "caps", "segment"}));
    EXPECT_EQ(way.added().size(), 2u) << "the same pads";
    EXPECT_EQ(way.stat("pushed-src_0"), 1u);
  }
  EXPECT_EQ(way.no_more_pads_count(), 3);
}

TEST(TensorIfRestart, AParsedPipelineCanRestart) {
  const auto pipeline = Ref<GstElement>::adopt(gst_parse_launch(
      "videotestsrc num-buffers=3 pattern=white ! video/x-raw,format=GRAY8,width=2,height=2 ! "
      "tensor_converter ! tensor_if name=way compared-value=A_VALUE "
      "compared-value-option=0:0:0:0,0 operator=GT supplied-value=5 then=PASSTHROUGH else=SKIP "
      "way.src_0 ! tensor_sink name=out sync=false",
      nullptr));
  ASSERT_TRUE(pipeline);
  const auto out = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  for (int round = 0; round < 3; ++round) {
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
    const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
        bus.get(), 60 * GST_SECOND, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
    ASSERT_TRUE(message);
    EXPECT_EQ(GST_MESSAGE_TYPE(message.get()), GST_MESSAGE_EOS) << "round " << round;
    EXPECT_EQ(test::stat(out.get(), "received"), 3u) << "round " << round;
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }
}

}  // namespace restart_test
}  // namespace weir::test
