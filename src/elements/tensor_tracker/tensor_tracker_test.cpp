// Tests of tensor_tracker: the column it fills, what it keeps, and streams that it refuses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <limits>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"

namespace weir {
namespace {

using namespace weir::test;
using Floats = std::vector<float>;

const std::string kRows =
    tensors("float32", "8:1", "10/1") +
    ",weir-columns=(string)\"x1,y1,x2,y2,score,class,parent,own\",weir-source=(string)net";

GstBuffer* row(Floats numbers, GstClockTime time) {
  Bytes bytes(numbers.size() * sizeof(float));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return frame(bytes, time);
}
Floats pushed(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  const Bytes bytes = content(out.get());
  Floats numbers((bytes.size() - kTensorHeaderBytes) / sizeof(float));
  std::memcpy(numbers.data(), bytes.data() + kTensorHeaderBytes, numbers.size() * sizeof(float));
  return numbers;
}

TEST(TensorTracker, AddsTheColumnAndKeepsTheOthers) {
  const auto h = harness_of("tensor_tracker min-hits=1", kRows);
  const Floats in{10, 10, 30, 40, 0.9f, 3, -1, 77};
  EXPECT_EQ(pushed(h, row(in, 0)), (Floats{10, 10, 30, 40, 0.9f, 3, -1, 77, 1}));
  EXPECT_EQ(pushed(h, row(in, GST_SECOND / 10)), (Floats{10, 10, 30, 40, 0.9f, 3, -1, 77, 1}));
  EXPECT_SAYS(caps_text(h), "own\\,track");
  EXPECT_SAYS(caps_text(h), "weir-source=(string)net");
}

TEST(TensorTracker, BackgroundAndChildrenHaveNoTrack) {
  const auto h = harness_of("tensor_tracker min-hits=1", kRows);
  EXPECT_EQ(pushed(h, row(Floats(8, 0), 0)), Floats(9, 0));
  const Floats child{10, 10, 30, 40, 0.9f, 3, 0, 77};
  EXPECT_EQ(pushed(h, row(child, GST_SECOND / 10)).back(), 0);
}

TEST(TensorTracker, FramesWithoutTimesAreFollowed) {
  const auto h = harness_of("tensor_tracker", kRows);
  const Floats in{10, 10, 30, 40, 0.9f, 3, -1, 77};
  EXPECT_EQ(pushed(h, row(in, GST_CLOCK_TIME_NONE)).back(), 0);  // min-hits is 2
  EXPECT_EQ(pushed(h, row(in, GST_CLOCK_TIME_NONE)).back(), 1);
}

TEST(TensorTracker, RefusesStreamsWithoutBoxes) {
  const auto error = error_of_pipeline(
      "videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=4,height=4 ! tensor_converter ! "
      "tensor_tracker ! fakesink");
  EXPECT_SAYS(error, "tensor_tracker needs rows of results with boxes");
  EXPECT_SAYS(error, "uint8 3:4:4");
  EXPECT_SAYS(error, "put tensor_decoder mode=detection");
}

TEST(TensorTracker, BoxesThatAreNotFiniteHaveNoTrack) {
  const auto h = harness_of("tensor_tracker min-hits=1", kRows);
  const float infinite = std::numeric_limits<float>::infinity();
  EXPECT_EQ(pushed(h, row({10, 10, infinite, 40, 0.9f, 3, -1, 77}, 0)).back(), 0);
}

}  // namespace
}  // namespace weir
