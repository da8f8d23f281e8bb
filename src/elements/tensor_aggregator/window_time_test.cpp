// Timestamps of windows: exact over a long stream, and the handling of missing or backward times.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"

namespace window_time_test {

using namespace weir::test;

constexpr char kName[] = "tensor_aggregator";
constexpr GstClockTime kNone = GST_CLOCK_TIME_NONE, kNine = 9 * GST_SECOND;

// 30000/1001 frames per second, computed in 128-bit integers.
uint64_t ntsc_time(uint64_t frames) {
  __extension__ using Wide = unsigned __int128;
  return static_cast<uint64_t>(Wide{frames} * 1001 * 1000000000 / 30000);
}

TEST(WindowTime, IsThatOfItsFirstFrame) {
  auto h = make_harness("tensor_aggregator frames-out=3 frames-dim=0", tensors("uint8", "1"));
  for (uint64_t i = 0; i < 6; ++i) {
    GstBuffer* in = frame(Bytes(1), 100 * i, 10);
    GST_BUFFER_DTS(in) = 100 * i + 1;
    ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  }
  for (uint64_t i = 0; i < 2; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), 300 * i);
    EXPECT_EQ(GST_BUFFER_DTS(out.get()), 300 * i + 1);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 30u);
  }
}

// docs/compatibility/routing.md 6.6: each frame is 1/framerate later than the previous one.
TEST(WindowTime, OfAFrameInsideABufferIsRelativeToTheBuffer) {
  auto h = make_harness("tensor_aggregator frames-in=4 frames-out=1 frames-dim=0",
                        tensors("uint8", "4", "40/1"));
  for (const uint64_t start : {1000u, 100'001'000u}) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(4), start, 100 * GST_MSECOND)), GST_FLOW_OK);
    for (uint64_t i = 0; i < 4; ++i) {
      auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      EXPECT_EQ(GST_BUFFER_PTS(out.get()), start + i * 25 * GST_MSECOND);
      EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 25 * GST_MSECOND);
    }
  }
}

// The numbers of docs/compatibility/routing.md 6.6: frames that tensor_converter combined keep
// their times when they are separated again.
TEST(WindowTime, OfFramesThatAConverterCollectedIsTheirOwn) {
  auto h = make_harness(
      "tensor_converter frames-per-tensor=3 ! tensor_aggregator frames-in=3 frames-out=1 "
      "frames-dim=3",
      "video/x-raw,format=GRAY8,width=4,height=4,framerate=30/1,interlace-mode=progressive");
  std::vector<GstClockTime> times;
  for (uint64_t i = 0; i < 6; ++i) {
    times.push_back(gst_util_uint64_scale(i, GST_SECOND, 30));
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(16), times[i], GST_SECOND / 30)), GST_FLOW_OK);
  }
  for (const GstClockTime time : times) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_NEAR(static_cast<double>(GST_BUFFER_PTS(out.get())), static_cast<double>(time), 1);
    EXPECT_NEAR(static_cast<double>(GST_BUFFER_DURATION(out.get())), GST_SECOND / 30, 1);
  }
}

// A million frames in buffers of 1000, windows of 100; only the first buffer has a timestamp.
TEST(WindowTime, DoesNotDriftOverAMillionFrames) {
  auto h = make_harness("tensor_aggregator frames-in=1000 frames-out=100 frames-dim=0",
                        tensors("uint8", "1000", "30000/1001"));
  for (uint64_t i = 0; i < 1000; ++i) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(1000), i ? kNone : 5, kNone)), GST_FLOW_OK);
    for (uint64_t k = 0; k < 10; ++k) {
      auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_EQ(GST_BUFFER_PTS(out.get()), 5 + ntsc_time(1000 * i + 100 * k)) << i << " " << k;
    }
  }
}

TEST(WindowTime, StaysUnknownWithoutTimestamps) {
  auto h = make_harness("tensor_aggregator frames-out=2 frames-dim=0", tensors("uint8", "1"));
  for (const auto time : {kNone, kNone, kNine, kNone, kNone, kNone})
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(1), time, kNone)), GST_FLOW_OK);
  for (const auto time : {kNone, kNine, kNine}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), time);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), kNone);
  }
}

TEST(WindowTime, IsUnknownInsideABufferWithoutARate) {
  auto h = make_harness("tensor_aggregator frames-in=2 frames-out=1 frames-dim=0",
                        tensors("uint8", "2", "0/1"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(2), 50, 8)), GST_FLOW_OK);
  for (int i = 0; i < 2; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), 50u);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 4u);
  }
}

TEST(WindowTime, ThatGoesBackwardsIsCounted) {
  for (const bool drop : {false, true}) {
    auto h = make_harness(std::string("tensor_aggregator frames-out=2 frames-dim=0") +
                              (drop ? " on-backwards-time=drop" : ""),
                          tensors("uint8", "1"));
    Errors errors(h);
    for (const GstClockTime time : {10, 20, 15, 30})
      ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(1), time, 1)), GST_FLOW_OK);
    EXPECT_SAYS(errors.next_warning(), "WEIR-2008: a timestamp goes backwards");
    EXPECT_EQ(stat(h, kName, "backwards-times"), 1u);
    EXPECT_EQ(stat(h, kName, "dropped-time"), drop ? 1u : 0u);
    EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), drop ? 1u : 2u);
  }
}

TEST(WindowTime, IsAddedToTheLatency) {
  const struct {
    const char* properties;
    const char* dims;
    GstClockTime latency;
  } cases[] = {{"frames-out=4 frames-dim=0", "1", 300 * GST_MSECOND},
               {"frames-out=10 frames-flush=1 frames-dim=0", "1", 900 * GST_MSECOND},
               {"frames-in=2 frames-out=1 frames-dim=0", "2", 0},
               {"frames-in=2 frames-out=2 frames-dim=0", "2", 0}};
  for (const auto& c : cases) {
    auto h = make_harness(std::string("tensor_aggregator ") + c.properties,
                          tensors("uint8", c.dims, "10/1"));
    gst_harness_set_upstream_latency(h.get(), 5 * GST_MSECOND);
    EXPECT_EQ(gst_harness_query_latency(h.get()), 5 * GST_MSECOND + c.latency) << c.properties;
  }
}

TEST(WindowTime, GivesADiscontinuityToTheFirstPartOnly) {
  auto h = make_harness("tensor_aggregator frames-in=2 frames-out=1 frames-dim=0",
                        tensors("uint8", "2"));
  GstBuffer* in = frame(Bytes(2), 0, 2);
  GST_BUFFER_FLAG_SET(in, GST_BUFFER_FLAG_DISCONT);
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  for (const bool expected : {true, false}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_FLAG_IS_SET(out.get(), GST_BUFFER_FLAG_DISCONT), expected);
  }
}

}  // namespace window_time_test
