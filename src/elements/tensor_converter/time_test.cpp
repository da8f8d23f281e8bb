// Timestamps of tensors: no drift over a long stream, and no waiting frames are lost.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/converter_test_support.hpp"

namespace time_test {

using namespace weir::testing_tensor_converter;

GstBuffer* timed(const Bytes& bytes, GstClockTime pts, GstClockTime duration) {
  GstBuffer* b = frame(bytes);
  GST_BUFFER_PTS(b) = pts;
  GST_BUFFER_DURATION(b) = duration;
  return b;
}
// Frames of four bytes at 30000/1001 per second.
Harness bytes_at_ntsc(const std::string& properties = "") {
  return harness("input-dim=4 input-type=uint8 " + properties,
                 "application/octet-stream,framerate=30000/1001");
}
// Computed in 128-bit integers, independently of gst_util_uint64_scale.
uint64_t ntsc_time(uint64_t frames) {
  __extension__ using Wide = unsigned __int128;
  return static_cast<uint64_t>(Wide{frames} * 1001 * 1000000000 / 30000);
}

TEST(ConverterTime, IsExactAfterAMillionFramesWithoutTimeStamps) {
  auto h = bytes_at_ntsc("frames-per-tensor=1001");
  constexpr uint64_t kBuffers = 1000, kFrames = 1001;
  const Bytes bytes(kFrames * 4);
  for (uint64_t i = 0; i < kBuffers; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(bytes)));
    ASSERT_EQ(GST_BUFFER_PTS(out.get()), ntsc_time(i * kFrames)) << i;
  }
  EXPECT_EQ(stat(h, "consumed"), kBuffers);
}

// Frames of a buffer are counted from its timestamp, which is rounded down once.
TEST(ConverterTime, IsNeverMoreThanANanosecondOffWhenBuffersAreCut) {
  auto h = bytes_at_ntsc();
  constexpr uint64_t kBuffers = 20, kFrames = 1001;
  const Bytes bytes(kFrames * 4);
  for (uint64_t i = 0; i < kBuffers; ++i) {
    ASSERT_EQ(gst_harness_push(h.get(), frame(bytes)), GST_FLOW_OK);
    for (uint64_t j = 0; j < kFrames; ++j) {
      auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_EQ(GST_BUFFER_PTS(out.get()), ntsc_time(i * kFrames) + ntsc_time(j)) << i << " " << j;
      ASSERT_LE(ntsc_time(i * kFrames + j) - GST_BUFFER_PTS(out.get()), 1u);
    }
  }
  EXPECT_EQ(stat(h, "pushed"), kBuffers * kFrames);
  EXPECT_EQ(stat(h, "consumed"), kBuffers);
}

TEST(ConverterTime, IsExactAcrossGatheredFrames) {
  auto h = bytes_at_ntsc("frames-per-tensor=7");
  constexpr uint64_t kOutputs = 1000;
  for (uint64_t i = 0; i < 7 * kOutputs; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_OK);
  for (uint64_t i = 0; i < kOutputs; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_EQ(GST_BUFFER_PTS(out.get()), ntsc_time(7 * i));
  }
}

TEST(ConverterTime, GoesOnFromTheLastTimeStampThatWasGiven) {
  auto h = bytes_at_ntsc();
  const auto next = [&h](GstBuffer* in) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    return GST_BUFFER_PTS(out.get());
  };
  constexpr auto kNone = GST_CLOCK_TIME_NONE;
  EXPECT_EQ(next(timed(Bytes(4), 5 * GST_SECOND, kNone)), 5 * GST_SECOND);
  EXPECT_EQ(next(frame(Bytes(4))), 5 * GST_SECOND + ntsc_time(1));
  EXPECT_EQ(next(frame(Bytes(4))), 5 * GST_SECOND + ntsc_time(2));
  // Backwards: given times are kept, and missing ones continue from there.
  EXPECT_EQ(next(timed(Bytes(4), 1 * GST_SECOND, kNone)), 1 * GST_SECOND);
  EXPECT_EQ(next(frame(Bytes(4))), 1 * GST_SECOND + ntsc_time(1));
  // A given duration has precedence over the rate.
  EXPECT_EQ(next(timed(Bytes(4), 2 * GST_SECOND, 7)), 2 * GST_SECOND);
  EXPECT_EQ(next(frame(Bytes(4))), 2 * GST_SECOND + 7);
}

TEST(ConverterTime, GoesOnWhenTheRateChanges) {
  auto h = bytes_at_ntsc();
  for (int i = 0; i < 3; ++i) gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
  EXPECT_EQ(change_caps(h, "application/octet-stream,framerate=10/1"), "");
  for (uint64_t i = 0; i < 3; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), ntsc_time(3) + i * 100 * GST_MSECOND);
  }
}

TEST(ConverterTime, GoesOnWhenTheFramesBecomeOfAnotherSize) {
  auto h = harness("", video("GRAY8", 4, 1));
  for (int i = 0; i < 3; ++i) gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
  EXPECT_EQ(change_caps(h, video("GRAY8", 8, 1)), "");
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(8))));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 300 * GST_MSECOND);
}

TEST(ConverterTime, OfAGatheredTensorIsThatOfItsFirstFrame) {
  auto h = bytes_at_ntsc("frames-per-tensor=2");
  const GstClockTime times[] = {9 * GST_SECOND, 3 * GST_SECOND, 1 * GST_SECOND, 2 * GST_SECOND};
  for (const auto time : times)
    ASSERT_EQ(gst_harness_push(h.get(), timed(Bytes(4), time, 10)), GST_FLOW_OK);
  for (const auto time : {9 * GST_SECOND, 1 * GST_SECOND}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), time);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 20u);
  }
}

TEST(ConverterTime, OfFramesThatWaitIsThatOfTheirOwnRate) {
  auto h = bytes_at_ntsc("frames-per-tensor=4");
  ASSERT_EQ(gst_harness_push(h.get(), timed(Bytes(24), 3 * GST_SECOND, GST_CLOCK_TIME_NONE)),
            GST_FLOW_OK);  // frames 4 and 5 wait
  gst_buffer_unref(gst_harness_pull(h.get()));
  EXPECT_EQ(change_caps(h, "application/octet-stream,framerate=1/1"), "");
  for (const uint64_t time : {8u, 20u})
    ASSERT_EQ(gst_harness_push(h.get(), timed(Bytes(12), time * GST_SECOND, GST_CLOCK_TIME_NONE)),
              GST_FLOW_OK);
  // For frames at 4, 5, 8, 9 / 10, 20, 21, 22: the first two at the NTSC rate, then one per second.
  for (const uint64_t time : {3 * GST_SECOND + ntsc_time(4), 10 * uint64_t{GST_SECOND}}) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), time);
  }
  EXPECT_EQ(stat(h, "dropped"), 0u);
}

TEST(ConverterTime, LastsAsLongAsItsFramesExactly) {
  auto h = bytes_at_ntsc("frames-per-tensor=300");
  for (uint64_t i = 0; i < 600; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), timed(Bytes(4), ntsc_time(i), GST_CLOCK_TIME_NONE)),
              GST_FLOW_OK);
  for (uint64_t i = 0; i < 2; ++i) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), ntsc_time(300 * i));
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), ntsc_time(300)) << "10.01 s";
  }
}

TEST(ConverterTime, CountsWhatWaitsAtTheEnd) {
  auto h = bytes_at_ntsc("frames-per-tensor=3");
  for (int i = 0; i < 5; ++i) ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_OK);
  EXPECT_EQ(stat(h, "consumed"), 3u);
  EXPECT_EQ(stat(h, "held"), 2u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(stat(h, "dropped-eos"), 2u);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(ConverterTime, CountsWhatAFlushAndOtherCapsThrowAway) {
  auto h = harness("frames-per-tensor=3", video("GRAY8", 4, 1));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_OK);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  EXPECT_EQ(stat(h, "dropped-flush"), 1u);
  gst_harness_push_event(h.get(), time_segment());
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_OK);
  EXPECT_EQ(change_caps(h, video("GRAY8", 4, 1) + ",pixel-aspect-ratio=4/3"), "");
  EXPECT_EQ(stat(h, "dropped-flush"), 1u) << "the tensors are the same";
  EXPECT_EQ(change_caps(h, video("GRAY8", 5, 1)), "");
  EXPECT_EQ(stat(h, "dropped-flush"), 2u);
  EXPECT_EQ(gst_harness_buffers_in_queue(h.get()), 0u);
}

TEST(ConverterTime, BeginsWhereASegmentOfBytesBegins) {
  auto h = bytes_at_ntsc();
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_BYTES);
  segment.start = 120;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), ntsc_time(30));
}

TEST(ConverterTime, HasNoUnitInOtherSegments) {
  auto h = bytes_at_ntsc();
  Errors errors(h);
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_DEFAULT);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  EXPECT_SAYS(errors.next(), "WEIR-2002: the segment has no known unit");
}

// Pushes bytes at these times and returns the output times.
std::vector<GstClockTime> times_through(const Harness& h, const std::vector<GstClockTime>& times) {
  for (const auto time : times)
    EXPECT_EQ(gst_harness_push(h.get(), timed(Bytes(4), time, 10)), GST_FLOW_OK);
  std::vector<GstClockTime> out;
  while (auto buffer = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get())))
    out.push_back(GST_BUFFER_PTS(buffer.get()));
  return out;
}

TEST(ConverterTime, ThatGoesBackwardsIsCountedReportedOnceAndForwarded) {
  auto h = bytes_at_ntsc();
  Errors errors(h);
  const std::vector<GstClockTime> times{5 * GST_SECOND, 3 * GST_SECOND, 4 * GST_SECOND, 0};
  EXPECT_EQ(times_through(h, times), times);
  EXPECT_EQ(stat(h, "backwards-times"), 2u);
  EXPECT_EQ(stat(h, "consumed"), 4u);
  const auto warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-2008: a timestamp goes backwards; these frames are counted");
  EXPECT_SAYS(warning, "offered: 0:00:03.000000000");
  EXPECT_SAYS(warning, "needed: at least 0:00:05.000000000");
  EXPECT_SAYS(warning, "fix: on-backwards-time=drop");
  EXPECT_EQ(errors.next_warning(), "");
}

TEST(ConverterTime, ThatGoesBackwardsIsDroppedIfConfigured) {
  auto h = bytes_at_ntsc("on-backwards-time=drop");
  Errors errors(h);
  EXPECT_EQ(times_through(h, {5 * GST_SECOND, 3 * GST_SECOND, 5 * GST_SECOND, 4 * GST_SECOND,
                              6 * GST_SECOND}),
            (std::vector<GstClockTime>{5 * GST_SECOND, 5 * GST_SECOND, 6 * GST_SECOND}));
  EXPECT_EQ(stat(h, "backwards-times"), 2u);
  EXPECT_EQ(stat(h, "dropped-time"), 2u);
  EXPECT_EQ(stat(h, "consumed"), 3u);
  EXPECT_EQ(stat(h, "held"), 0u);
  EXPECT_SAYS(errors.next_warning(), "these frames are dropped and counted");
  EXPECT_EQ(errors.next_warning(), "");
}

TEST(ConverterTime, RestartsInANewSegmentAndMayRunBackwardsInAReversedOne) {
  auto h = bytes_at_ntsc("on-backwards-time=drop");
  EXPECT_EQ(times_through(h, {5 * GST_SECOND}).size(), 1u);
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  EXPECT_EQ(times_through(h, {3 * GST_SECOND}).size(), 1u);
  segment.rate = -1;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  EXPECT_EQ(times_through(h, {2 * GST_SECOND, 1 * GST_SECOND}).size(), 2u);
  EXPECT_EQ(stat(h, "backwards-times"), 0u);
}

TEST(ConverterTime, ThatIsMissingIsCountedWhetherItIsFilledInOrNot) {
  for (const char* properties : {"", "set-timestamp=false"}) {
    auto h = bytes_at_ntsc(properties);
    times_through(h, {GST_CLOCK_TIME_NONE, 5, GST_CLOCK_TIME_NONE});
    EXPECT_EQ(stat(h, "missing-times"), 2u) << properties;
    EXPECT_EQ(stat(h, "backwards-times"), 0u) << properties;
  }
}

}  // namespace time_test
