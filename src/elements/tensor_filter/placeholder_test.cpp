// tensor_filter downstream of a tensor_converter that sends placeholder caps before the first
// frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tests/flexible_frame_test_support.hpp"

namespace weir::test {
namespace tensor_filter_placeholder_test {

constexpr char kPlaceholder[] =
    "other/tensor,dimension=(string)1,type=(string)uint8,framerate=(fraction)10/1";

// y = x + 1 on float32 [-1, 4].
std::string filter(const std::string& properties) {
  const std::string path = testing::TempDir() + "weir_placeholder_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=fake model=" + path + " " + properties;
}

GstBuffer* floats() {
  return flexible_frame<float>({ElementType::Float32, Shape{4, 1}, ""}, {1, 2, 3, 4});
}
GstBuffer* bytes_and_floats() {
  return gst_buffer_append(flexible_frame<uint8_t>({ElementType::UInt8, Shape{3}, ""}, {7, 8, 9}),
                           floats());
}

using Names = std::vector<std::string>;

void expect_result(const Harness& h, GstBuffer* in) {
  Errors errors(h);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(errors.next(), "");
  ASSERT_TRUE(out);
  EXPECT_EQ(values<float>(out.get()), (std::vector<float>{2, 3, 4, 5}));
}

TEST(FilterPlaceholder, ACombinationIsCheckedWithTheFirstFrame) {
  const auto h = make_harness("tensor_converter ! " + filter("input-combination=1"));
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kFlexibleCaps);
  gst_harness_push_event(h.get(), gst_event_new_gap(0, 1));
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(event_names(h), Names{"stream-start"}) << "no caps and no later events";
  expect_result(h, bytes_and_floats());
  EXPECT_EQ(event_names(h), (Names{"custom-downstream-sticky", "caps", "segment"}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)4:1, type=(string)float32");
  expect_result(h, bytes_and_floats());
  gst_harness_push_event(h.get(), gst_event_new_gap(0, 1));
  EXPECT_EQ(event_names(h), Names{"gap"});
}

TEST(FilterPlaceholder, DeclaredTensorsAreCheckedWithTheFirstFrame) {
  for (const char* properties :
       {"", "output=4:1 outputtype=float32", "input=4:1 inputtype=float32", "outputtype=float32"}) {
    const auto h = make_harness("tensor_converter ! " + filter(properties));
    Errors errors(h);
    gst_harness_set_src_caps_str(h.get(), kFlexibleCaps);
    EXPECT_EQ(errors.next(), "") << properties;
    expect_result(h, floats());
  }
}

TEST(FilterPlaceholder, DownstreamOfATransformIsCheckedToo) {
  const auto h =
      make_harness("tensor_converter ! tensor_transform mode=typecast option=float32 ! " +
                   filter("input-combination=1"));
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kFlexibleCaps);
  EXPECT_EQ(errors.next(), "");
  expect_result(h, bytes_and_floats());
}

TEST(FilterPlaceholder, FramesOfPlaceholderCapsAreErrors) {
  const auto h = make_harness(filter("input-combination=1"));
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kPlaceholder);
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1})), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_SAYS(errors.next(), "input-combination");
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-error"), 1u);
  EXPECT_EQ(stat(h, "tensor_filter", "held"), 0u);
}

TEST(FilterPlaceholder, LaterInvalidCapsAreAnErrorImmediately) {
  const auto h = make_harness(filter("input-combination=1"));
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kPlaceholder);
  EXPECT_EQ(errors.next(), "");
  gst_harness_set_src_caps_str(h.get(), tensors("float32", "4:1").c_str());
  EXPECT_SAYS(errors.next(), "input-combination");
}

TEST(FilterPlaceholder, AStreamWithoutFramesEnds) {
  const auto h = make_harness("tensor_converter ! " + filter("input-combination=1"), kFlexibleCaps);
  Errors errors(h);
  EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_eos()));
  EXPECT_EQ(event_names(h), (Names{"stream-start", "eos"}));
  EXPECT_EQ(errors.next(), "");
}

TEST(FilterPlaceholder, AFlushDropsTheStoredSegment) {
  const auto h = make_harness(filter("input-combination=1"), kPlaceholder);
  event_names(h);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  const auto caps =
      Ref<GstCaps>::adopt(gst_caps_from_string(tensors("uint8,float32", "3,4:1").c_str()));
  gst_harness_push_event(h.get(), gst_event_new_caps(caps.get()));
  EXPECT_EQ(event_names(h),
            (Names{"flush-start", "flush-stop", "custom-downstream-sticky", "caps", "segment"}));
}

}  // namespace tensor_filter_placeholder_test
}  // namespace weir::test
