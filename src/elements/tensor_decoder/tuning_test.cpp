// tensor_decoder whose mode and options change while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tests/tuning_test_support.hpp"

namespace tensor_decoder_tuning_test {

using namespace weir::test;
const Bytes kPixels{1, 2, 3, 4, 5, 6};

Tuned tuned(const std::string& line) {
  return {"tensor_decoder", line, "other/tensor,dimension=(string)3:2:1,type=uint8,framerate=30/1"};
}

TEST(TuningDecoder, AnotherOptionAndAnotherModeActOnTheNextFrame) {
  auto t = tuned("tensor_decoder mode=direct_video");
  EXPECT_EQ(t.push<>(kPixels).size(), 8u) << "lines of four bytes";
  EXPECT_SAYS(t.caps(), "format=(string)RGB");
  t.set("option1", "BGR");
  EXPECT_EQ(t.push<>(kPixels).size(), 8u);
  EXPECT_SAYS(t.caps(), "format=(string)BGR");
  t.set("option1", "");
  t.set("mode", "octet_stream");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  EXPECT_SAYS(t.caps(), "application/octet-stream");
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(TuningDecoder, WhatCannotDecodeTheStreamIsRefusedAndReadsBackAsBefore) {
  auto t = tuned("tensor_decoder mode=octet_stream");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  t.set("mode", "no_such_decoder");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-3010");
  EXPECT_EQ(t.get("mode"), "octet_stream");
  t.set("mode", "image_labeling");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-");
  EXPECT_EQ(t.get("mode"), "octet_stream");
  EXPECT_EQ(t.messages.next(), "") << "no error";
}

TEST(TuningDecoder, WhatDownstreamDoesNotTakeIsRefused) {
  auto t = tuned("tensor_decoder mode=octet_stream ! capsfilter caps=application/octet-stream");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  t.set("mode", "direct_video");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  EXPECT_SAYS(t.messages.next_warning(), "video/x-raw");
  EXPECT_EQ(t.get("mode"), "octet_stream");
}

// A frame passes between two writes: the first alone is rejected.
TEST(TuningDecoder, ASecondWriteCompletesTheFirst) {
  const std::string labels = testing::TempDir() + "weir-tuned-labels.txt";
  std::ofstream(labels) << "a\nb\nc\nd\ne\nf\n";
  Tuned t("tensor_decoder", "tensor_decoder mode=octet_stream",
          "other/tensor,dimension=(string)6,type=uint8,framerate=30/1");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  t.set("mode", "image_labeling");
  EXPECT_EQ(t.push<>(kPixels), kPixels);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-");
  EXPECT_EQ(t.get("mode"), "octet_stream");
  t.set("option1", labels.c_str());
  EXPECT_EQ(t.push<>(kPixels), (Bytes{'f', 0}));
  EXPECT_EQ(t.get("mode"), "image_labeling");
  EXPECT_EQ(t.get("option1"), labels);
  EXPECT_EQ(t.messages.next_warning(), "");
  EXPECT_EQ(t.messages.next(), "");
}

TEST(TuningDecoder, ARejectedWriteKeepsOtherWrites) {
  auto t = tuned("tensor_decoder mode=direct_video");
  t.push<>(kPixels);
  t.set("mode", "no_such_decoder");
  t.push<>(kPixels);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-3010");
  t.set("option1", "BGR");
  EXPECT_EQ(t.push<>(kPixels).size(), 8u);
  EXPECT_SAYS(t.caps(), "format=(string)BGR");
  EXPECT_EQ(t.get("mode"), "direct_video");
  EXPECT_EQ(t.get("option1"), "BGR");
  t.set("mode", "direct_video");  // discards the rejected value
  EXPECT_EQ(t.push<>(kPixels).size(), 8u);
  EXPECT_EQ(t.messages.next_warning(), "");
}

}  // namespace tensor_decoder_tuning_test
