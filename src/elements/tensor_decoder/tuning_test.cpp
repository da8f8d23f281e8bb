// tensor_decoder whose mode and options change while frames flow.
#include "elements/tests/tuned.hpp"

namespace {

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

}  // namespace
