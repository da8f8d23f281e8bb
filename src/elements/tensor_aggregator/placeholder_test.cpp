// tensor_aggregator downstream of a tensor_converter that sends placeholder caps first.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/flexible_frame_test_support.hpp"

namespace weir::test {
namespace tensor_aggregator_placeholder_test {

using Names = std::vector<std::string>;
constexpr char kPlaceholder[] =
    "other/tensor,dimension=(string)1,type=(string)uint8,framerate=(fraction)10/1";

TEST(AggregatorPlaceholder, CountsFramesInTheFirstBuffer) {
  const auto h =
      make_harness("tensor_converter ! tensor_aggregator frames-in=4 frames-out=2 frames-dim=0");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kFlexibleCaps);
  gst_harness_push_event(h.get(), gst_event_new_gap(0, 1));
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(event_names(h), Names{"stream-start"}) << "no caps and no later events";
  ASSERT_EQ(gst_harness_push(h.get(),
                             flexible_frame<uint8_t>({ElementType::UInt8, Shape{8}, ""}, ramp(8))),
            GST_FLOW_OK);
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(event_names(h), (Names{"caps", "segment"}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)4,");
  for (const Bytes& window : {Bytes{0, 1, 2, 3}, Bytes{4, 5, 6, 7}})
    EXPECT_EQ(content(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())).get()), window);
}

TEST(AggregatorPlaceholder, ReportsAFrameOfPlaceholderCaps) {
  const auto h = make_harness("tensor_aggregator frames-in=4 frames-dim=0");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kPlaceholder);
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_SAYS(errors.next(), "a buffer does not contain frames-in frames");
  EXPECT_EQ(stat(h, "tensor_aggregator", "dropped-error"), 1u);
}

TEST(AggregatorPlaceholder, EndsAStreamWithoutFrames) {
  const auto h =
      make_harness("tensor_converter ! tensor_aggregator frames-in=4 frames-dim=0", kFlexibleCaps);
  Errors errors(h);
  EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_eos()));
  EXPECT_EQ(event_names(h), (Names{"stream-start", "eos"}));
  EXPECT_EQ(errors.next(), "");
}

}  // namespace tensor_aggregator_placeholder_test
}  // namespace weir::test
