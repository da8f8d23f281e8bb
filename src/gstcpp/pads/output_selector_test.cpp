// switch_output: what the new pad receives, and when.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/output_selector.hpp"

#include <gtest/gtest.h>

#include <string>

namespace weir::gst {
namespace output_selector_test {

// An output-selector with two pads; the test pushes into it and records what arrives at each peer.
class OutputSelectorTest : public ::testing::Test {
 protected:
  struct End {
    Ref<GstPad> selected, pad;
    std::string seen;
  };

  void SetUp() override {
    selector_ = Ref<GstElement>::adopt(
        GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make("output-selector", nullptr))));
    feeding_ = Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("src", GST_PAD_SRC))));
    gst_pad_set_active(feeding_.get(), TRUE);
    for (auto& end : ends_) {
      end.selected = Ref<GstPad>::adopt(gst_element_request_pad_simple(selector_.get(), "src_%u"));
      end.pad = Ref<GstPad>::adopt(
          GST_PAD(gst_object_ref_sink(gst_pad_new_from_static_template(&any_template, "sink"))));
      gst_pad_set_element_private(end.pad.get(), &end.seen);
      gst_pad_set_event_function(end.pad.get(), note_event);
      gst_pad_set_chain_function(end.pad.get(), note_frame);
      gst_pad_set_active(end.pad.get(), TRUE);
      gst_pad_link(end.selected.get(), end.pad.get());
    }
    gst_element_set_state(selector_.get(), GST_STATE_PLAYING);
  }
  void TearDown() override {
    gst_pad_set_active(feeding_.get(), FALSE);
    gst_element_set_state(selector_.get(), GST_STATE_NULL);
  }

  void link() {
    const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(selector_.get(), "sink"));
    ASSERT_EQ(gst_pad_link(feeding_.get(), sink.get()), GST_PAD_LINK_OK);
    gst_pad_push_event(feeding_.get(), gst_event_new_stream_start("one"));
    send_caps(8);
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(feeding_.get(), gst_event_new_segment(&segment));
  }
  void send_caps(int width) {
    const auto caps = Ref<GstCaps>::adopt(
        gst_caps_new_simple("video/x-raw", "width", G_TYPE_INT, width, nullptr));
    gst_pad_push_event(feeding_.get(), gst_event_new_caps(caps.get()));
  }
  void send_frame() { gst_pad_push(feeding_.get(), gst_buffer_new()); }

  static gboolean note_event(GstPad* pad, GstObject*, GstEvent* event) {
    std::string what = GST_EVENT_TYPE_NAME(event);
    if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
      GstCaps* caps = nullptr;
      int width = 0;
      gst_event_parse_caps(event, &caps);
      gst_structure_get_int(gst_caps_get_structure(caps, 0), "width", &width);
      what += "-" + std::to_string(width);
    }
    note(pad, what);
    gst_event_unref(event);
    return TRUE;
  }
  static GstFlowReturn note_frame(GstPad* pad, GstObject*, GstBuffer* buffer) {
    note(pad, "frame");
    gst_buffer_unref(buffer);
    return GST_FLOW_OK;
  }
  // An immediate repetition is recorded once: the selector sends its own segment.
  static void note(GstPad* pad, const std::string& what) {
    auto& seen = *static_cast<std::string*>(gst_pad_get_element_private(pad));
    if (!seen.ends_with(what)) seen += (seen.empty() ? "" : " ") + what;
  }

  static inline GstStaticPadTemplate any_template =
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
  Ref<GstElement> selector_;
  Ref<GstPad> feeding_;
  End ends_[2];
};

TEST_F(OutputSelectorTest, TheNewPadFirstGetsTheStickyEventsOfTheSelector) {
  link();
  switch_output(ends_[1].selected);
  EXPECT_EQ(ends_[1].seen, "");  // nothing goes downstream in this thread
  send_caps(16);
  EXPECT_EQ(ends_[1].seen, "stream-start caps-16");
  send_frame();
  EXPECT_EQ(ends_[1].seen, "stream-start caps-16 segment frame");
  EXPECT_EQ(ends_[0].seen, "stream-start caps-8 segment");
}

TEST_F(OutputSelectorTest, APadDeselectedBeforeTheNextFrameGetsNoEvents) {
  link();
  switch_output(ends_[1].selected);
  switch_output(ends_[0].selected);
  send_frame();
  EXPECT_EQ(ends_[1].seen, "");
  EXPECT_EQ(ends_[0].seen, "stream-start caps-8 segment frame");
}

TEST_F(OutputSelectorTest, APadSelectedAgainGetsOnlyNewEvents) {
  link();
  switch_output(ends_[1].selected);
  send_frame();
  switch_output(ends_[0].selected);
  send_frame();
  ends_[0].seen.clear(), ends_[1].seen.clear();
  switch_output(ends_[1].selected);
  send_frame();
  EXPECT_EQ(ends_[0].seen, "");
  EXPECT_EQ(ends_[1].seen, "segment frame");
}

TEST_F(OutputSelectorTest, AnUnlinkedSelectorSwitchesImmediately) {
  switch_output(ends_[1].selected);
  link();
  send_frame();
  EXPECT_EQ(ends_[1].seen, "stream-start caps-8 segment frame");
}

TEST_F(OutputSelectorTest, AReleasedPadIsIgnored) {
  link();
  gst_element_release_request_pad(selector_.get(), ends_[1].selected.get());
  switch_output(ends_[1].selected);
  send_frame();
  EXPECT_EQ(ends_[0].seen, "stream-start caps-8 segment frame");
}

}  // namespace output_selector_test
}  // namespace weir::gst
