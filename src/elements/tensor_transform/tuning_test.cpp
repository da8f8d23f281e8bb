// tensor_transform whose properties change while frames flow, or are set after the start.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>
#include <vector>

#include "elements/tests/tuning_test_support.hpp"
#include "gstcpp/pads/early_events.hpp"

namespace tensor_transform_tuning_test {

using namespace weir::test;
using Bytes = std::vector<uint8_t>;

constexpr char kBytes[] = "other/tensor,dimension=(string)3:2,type=uint8,framerate=30/1";
const Bytes kSix{0, 1, 2, 127, 200, 255};

Tuned tuned(const std::string& line) {
  return {"tensor_transform", line, kBytes};
}

TEST(TransformPropertyChange, NewOptionAppliesToTheNextFrame) {
  auto t = tuned("tensor_transform mode=arithmetic option=add:1");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
  t.set("option", "add:2");
  EXPECT_EQ(t.get("option"), "add:2");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{2, 3, 4, 129, 202, 255}));
}

TEST(TransformPropertyChange, NewModeRenegotiates) {
  auto t = tuned("tensor_transform mode=arithmetic option=add:1");
  t.push<uint8_t>(kSix);
  t.set("mode", "typecast");
  t.set("option", "int16");
  EXPECT_EQ(t.push<int16_t>(kSix), (std::vector<int16_t>{0, 1, 2, 127, 200, 255}));
  EXPECT_SAYS(t.caps(), "type=(string)int16");
  t.set("option", "1:0:2:3");
  t.set("mode", "transpose");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{0, 127, 1, 200, 2, 255}));
  EXPECT_SAYS(t.caps(), "dimension=(string)2:3");
}

TEST(TransformPropertyChange, ApplyAndAccelerationApply) {
  Tuned t("tensor_transform", "tensor_transform mode=arithmetic option=add:1 apply=1",
          "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,4\","
          "types=(string)\"uint8,uint8\",framerate=30/1");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{0, 1, 3, 128, 201, 255}));
  t.set("apply", "0");
  t.set("acceleration", "false");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 2, 127, 200, 255}));
  t.set("apply", "2");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 2, 127, 200, 255}));
  EXPECT_SAYS(t.messages.next_warning(), "apply");
  EXPECT_EQ(t.get("apply"), "0");
}

TEST(TransformPropertyChange, AnUnreadableOptionIsRejectedImmediately) {
  auto t = tuned("tensor_transform mode=arithmetic option=add:1");
  t.push<uint8_t>(kSix);
  t.set("option", "garbage::");
  EXPECT_EQ(t.get("option"), "add:1");
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-1001");
  t.set("apply", "x");
  EXPECT_EQ(t.get("apply"), "");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
}

TEST(TransformPropertyChange, HalfAChangeKeepsTheOldValuesWithAWarning) {
  auto t = tuned("tensor_transform mode=arithmetic option=add:1");
  t.push<uint8_t>(kSix);
  t.set("mode", "transpose");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-1001");
  EXPECT_EQ(t.get("mode"), "arithmetic");
  t.set("option", "1:0:2:3");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{0, 127, 1, 200, 2, 255}));
  EXPECT_EQ(t.get("mode"), "transpose");
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(TransformPropertyChange, ASecondWriteCompletesAChangeThatDownstreamRejected) {
  auto t = tuned(
      "tensor_transform mode=clamp option=0:1 ! capsfilter "
      "caps=other/tensor,dimension=(string)3:2");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{0, 1, 1, 1, 1, 1}));
  t.set("mode", "dimchg");  // 2:3
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{0, 1, 1, 1, 1, 1}));
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-2001");
  EXPECT_EQ(t.get("mode"), "clamp");
  t.set("option", "2:3");
  EXPECT_EQ(t.push<uint8_t>(kSix), kSix);
  EXPECT_EQ(t.get("mode"), "dimchg");
  EXPECT_EQ(t.get("option"), "2:3");
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(TransformPropertyChange, OutputThatDownstreamRejectsIsRejectedAndRestored) {
  auto t = tuned(
      "tensor_transform mode=arithmetic option=add:1 ! capsfilter "
      "caps=other/tensor,dimension=(string)3:2,type=(string)uint8");
  t.push<uint8_t>(kSix);
  t.set("option", "typecast:float32,add:1");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
  EXPECT_SAYS(t.messages.next_warning(), "float32");
  EXPECT_EQ(t.get("option"), "add:1");
}

TEST(TransformPropertyChange, ModeAndOptionCanBeSetBeforeTheFirstFrame) {
  auto t = tuned("tensor_transform");
  t.set("mode", "arithmetic");
  t.set("option", "add:1");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
  const auto segment =
      Ref<GstEvent>::adopt(gst_pad_get_sticky_event(t.harness->sinkpad, GST_EVENT_SEGMENT, 0));
  EXPECT_TRUE(segment) << "earlier events follow the mode";
}

TEST(TransformPropertyChange, OtherCapsBeforeTheFirstFrameKeepEarlierEvents) {
  auto t = tuned("tensor_transform");
  gst_harness_push_event(t.harness.get(),
                         gst_event_new_tag(gst_tag_list_new(GST_TAG_TITLE, "a title", nullptr)));
  t.set("mode", "arithmetic");
  t.set("option", "add:1");
  const auto caps = Ref<GstCaps>::adopt(
      gst_caps_from_string("other/tensor,dimension=(string)2:3,type=uint8,framerate=30/1"));
  EXPECT_TRUE(gst_harness_push_event(t.harness.get(), gst_event_new_caps(caps.get())));
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
  EXPECT_SAYS(t.caps(), "dimension=(string)2:3");
  for (const auto type : {GST_EVENT_SEGMENT, GST_EVENT_TAG})
    EXPECT_TRUE(Ref<GstEvent>::adopt(gst_pad_get_sticky_event(t.harness->sinkpad, type, 0)))
        << gst_event_type_get_name(type);
  EXPECT_EQ(t.messages.next(), "");
}

// A source that sends only GAP events, for hours.
TEST(TransformPropertyChange, KeepsABoundedNumberOfGapsBeforeTheFirstFrame) {
  auto t = tuned("tensor_transform");
  constexpr GstClockTime kGaps = 1000;
  for (GstClockTime i = 0; i < kGaps; ++i)
    gst_harness_push_event(t.harness.get(), gst_event_new_gap(i, 1));
  t.set("mode", "arithmetic");
  t.set("option", "add:1");
  EXPECT_EQ(t.push<uint8_t>(kSix), (Bytes{1, 2, 3, 128, 201, 255}));
  size_t gaps = 0;
  GstClockTime newest = 0;
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(t.harness.get()))) {
    if (GST_EVENT_TYPE(event.get()) != GST_EVENT_GAP) continue;
    ++gaps;
    gst_event_parse_gap(event.get(), &newest, nullptr);
  }
  EXPECT_EQ(gaps, size_t{weir::gst::EarlyEvents::kMaxOfAType});
  EXPECT_EQ(newest, kGaps - 1);
  EXPECT_EQ(t.messages.next(), "");
}

TEST(TransformPropertyChange, TheFirstFrameNeedsAMode) {
  for (const char* line : {"tensor_transform", "tensor_transform mode=arithmetic"}) {
    auto t = tuned(line);
    EXPECT_EQ(gst_harness_push(t.harness.get(), frame(kSix)), GST_FLOW_NOT_NEGOTIATED) << line;
    EXPECT_SAYS(t.messages.next(), "mode and option are not set");
    EXPECT_EQ(stat(t.harness, "tensor_transform", "dropped-error"), 1u);
  }
}

TEST(TransformPropertyChange, AStreamWithoutFramesNeedsNone) {
  auto t = tuned("tensor_transform");
  EXPECT_TRUE(gst_harness_push_event(t.harness.get(), gst_event_new_eos()));
  EXPECT_EQ(t.messages.next(), "");
}

}  // namespace tensor_transform_tuning_test
