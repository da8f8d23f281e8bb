// Caps that reach an element whose source pad is already inactive, as when a branch is removed from
// a playing pipeline, must not cause an error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"

namespace weir::test {
namespace tests_shutdown_test {

struct Case {
  const char* launch;
  const char* caps;
};

class ShutElement : public ::testing::TestWithParam<Case> {};

constexpr char kFloats[] = "other/tensor,dimension=(string)4:2,type=(string)float32,framerate=30/1";

TEST_P(ShutElement, PostsNoErrorForCaps) {
  const auto element = lone_element(GetParam().launch);
  const auto sink = lone_element("fakesink");
  const auto in = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  const auto out = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  ASSERT_TRUE(gst_element_link(element.get(), sink.get()));
  Errors errors(element.get());
  gst_element_set_state(sink.get(), GST_STATE_PAUSED);
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  gst_pad_set_active(out.get(), FALSE);
  gst_pad_send_event(in.get(), gst_event_new_stream_start("test"));
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(GetParam().caps));
  gst_pad_send_event(in.get(), gst_event_new_caps(caps.get()));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  gst_element_set_state(sink.get(), GST_STATE_NULL);
  EXPECT_EQ(errors.next(), "");
}

INSTANTIATE_TEST_SUITE_P(
    Elements, ShutElement,
    ::testing::Values(
        Case{"tensor_converter",
             "video/x-raw,format=RGB,width=4,height=4,framerate=30/1,interlace-mode=progressive"},
        Case{"tensor_filter framework=fake model=/proc/self/exe", kFloats},
        Case{"tensor_transform mode=typecast option=uint8", kFloats},
        Case{"tensor_sparse_enc",
             "other/tensors,format=static,num_tensors=1,dimensions=(string)4:2,"
             "types=(string)float32,framerate=30/1"}));

}  // namespace tests_shutdown_test
}  // namespace weir::test
