// tensor_converter whose properties change while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/tuning_test_support.hpp"

namespace tensor_converter_tuning_test {

using namespace weir::test;

Tuned tuned(const std::string& properties) {
  return {"tensor_converter", "tensor_converter " + properties,
          "application/octet-stream,framerate=30/1"};
}

TEST(TuningConverter, OtherTensorsAreNegotiatedWithTheNextFrame) {
  auto t = tuned("input-dim=4 input-type=uint8");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  t.set("input-dim", "2:2");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  EXPECT_SAYS(t.caps(), "dimensions=(string)2:2");
  t.set("frames-per-tensor", "2");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}), Bytes{});
  EXPECT_EQ(t.push<>({5, 6, 7, 8}), (Bytes{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(TuningConverter, TimestampsAreFilledInOrNot) {
  auto t = tuned("input-dim=1 input-type=uint8 set-timestamp=false");
  const auto time = [&] {
    const auto out =
        Ref<GstBuffer>::adopt(gst_harness_push_and_pull(t.harness.get(), frame(Bytes{1})));
    return GST_BUFFER_PTS(out.get());
  };
  EXPECT_EQ(time(), GST_CLOCK_TIME_NONE);
  t.set("set-timestamp", "true");
  EXPECT_NE(time(), GST_CLOCK_TIME_NONE);
}

TEST(TuningConverter, WhatDoesNotFitTheStreamIsRefusedAndReadsBackAsBefore) {
  auto t = tuned("input-dim=4 input-type=uint8");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  t.set("input-type", "uint9");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}), (Bytes{1, 2, 3, 4}));
  EXPECT_SAYS(t.messages.next_warning(), "uint9");
  EXPECT_EQ(t.get("input-type"), "uint8");
  t.set("mode", "custom-nothing:x");
  EXPECT_EQ(t.get("mode"), "");
  EXPECT_SAYS(t.messages.next_warning(), "custom-nothing");
  t.set("mode", "custom-code:absent");
  EXPECT_SAYS(t.messages.next_warning(), "no function is registered");
  EXPECT_EQ(t.push<>({5, 6, 7, 8}), (Bytes{5, 6, 7, 8}));
  EXPECT_EQ(t.get("mode"), "");
  EXPECT_EQ(t.messages.next(), "") << "no error";
}

TEST(TuningConverter, WhatDoesNotDivideTheNextBufferIsRefused) {
  auto t = tuned("input-dim=4 input-type=uint8");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  t.set("input-dim", "3");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}), (Bytes{1, 2, 3, 4}));
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-2004: a buffer does not hold whole frames");
  EXPECT_EQ(t.get("input-dim"), "4");
  t.set("input-dim", "3");
  EXPECT_EQ(t.push<>({1, 2, 3}), (Bytes{1, 2, 3})) << "a buffer of the new size";
  EXPECT_EQ(t.messages.next_warning(), "");
  t.set("input-type", "float64");
  EXPECT_EQ(t.push<>({1, 2, 3, 4, 5}).size(), 0u) << "it fits neither";
  EXPECT_SAYS(t.messages.next(), "WEIR-2004");
}

TEST(TuningConverter, ASecondWriteCompletesTheFirst) {
  auto t = tuned("input-dim=4 input-type=uint8");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  t.set("input-dim", "2,2");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-");
  EXPECT_EQ(t.get("input-dim"), "4");
  t.set("input-type", "uint8,uint8");
  EXPECT_EQ(t.push<>({1, 2, 3, 4}).size(), 4u);
  EXPECT_SAYS(t.caps(), "num_tensors=(int)2");
  EXPECT_EQ(t.get("input-dim"), "2,2");
  EXPECT_EQ(t.get("input-type"), "uint8,uint8");
  EXPECT_EQ(t.messages.next_warning(), "");
}

}  // namespace tensor_converter_tuning_test
