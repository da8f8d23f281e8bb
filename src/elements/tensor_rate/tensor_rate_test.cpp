// tensor_rate in a harness: counts that add up, times, flags, and the QoS events sent upstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <random>

#include "elements/tests/element_test_support.hpp"

namespace tensor_rate_test {

using namespace weir::test;

constexpr char kRate[] = "tensor_rate";
constexpr GstClockTime kMs = GST_MSECOND;

Harness rate(const std::string& properties, const std::string& in = "10/1") {
  return make_harness("tensor_rate " + properties, tensors("uint8", "1", in));
}
uint64_t counter(const Harness& h, const char* name) {
  guint64 value = 0;
  g_object_get(find_element(h, kRate).get(), name, &value, nullptr);
  return value;
}
void push(const Harness& h, uint8_t value, GstClockTime time, GstClockTime duration = 100 * kMs) {
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{value}, time, duration)), GST_FLOW_OK);
}
struct Out {
  uint8_t value;
  GstClockTime time;
  bool operator==(const Out&) const = default;
};
std::ostream& operator<<(std::ostream& s, const Out& o) {
  return s << int{o.value} << " at " << o.time;
}
std::vector<Out> pull_all(const Harness& h) {
  std::vector<Out> out;
  while (auto b = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get())))
    out.push_back({content(b.get())[0], GST_BUFFER_PTS(b.get())});
  return out;
}
void expect_sums(const Harness& h) {
  const auto held = stat(h, kRate, "held");
  EXPECT_EQ(counter(h, "in"),
            counter(h, "out") - counter(h, "duplicate") + counter(h, "drop") + held);
  EXPECT_EQ(stat(h, kRate, "received"),
            stat(h, kRate, "consumed") + stat(h, kRate, "dropped") + held);
  EXPECT_EQ(stat(h, kRate, "pushed"), counter(h, "out"));
}

TEST(TensorRate, HalvesARate) {
  auto h = rate("framerate=5/1");
  for (uint8_t i = 0; i < 10; ++i) push(h, i, i * 100 * kMs);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(
      pull_all(h),
      (std::vector<Out>{{0, 0}, {2, 200 * kMs}, {4, 400 * kMs}, {6, 600 * kMs}, {8, 800 * kMs}}));
  EXPECT_EQ(counter(h, "in"), 10u);
  EXPECT_EQ(counter(h, "out"), 5u);
  EXPECT_EQ(counter(h, "drop"), 5u);
  EXPECT_EQ(counter(h, "duplicate"), 0u);
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)5/1");
  expect_sums(h);
}

TEST(TensorRate, DoublesARateWithoutCopyingBytes) {
  auto h = rate("framerate=20/1");
  for (uint8_t i = 0; i < 3; ++i) push(h, i, i * 100 * kMs);
  std::vector<bool> repeated;
  for (uint64_t n = 0; n < 4; ++n) {
    auto b = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(b.get())[0], n / 2);
    EXPECT_EQ(GST_BUFFER_PTS(b.get()), n * 50 * kMs);
    EXPECT_EQ(GST_BUFFER_DURATION(b.get()), 50 * kMs);
    EXPECT_EQ(GST_BUFFER_OFFSET(b.get()), n);
    EXPECT_EQ(GST_BUFFER_OFFSET_END(b.get()), n + 1);
    EXPECT_EQ(GST_BUFFER_FLAG_IS_SET(b.get(), GST_BUFFER_FLAG_DISCONT), n == 0);
    repeated.push_back(GST_BUFFER_FLAG_IS_SET(b.get(), GST_BUFFER_FLAG_GAP));
  }
  EXPECT_EQ(repeated, (std::vector<bool>{false, true, false, true}));
  EXPECT_EQ(stat(h, kRate, "bytes-copied"), 0u);
  EXPECT_EQ(counter(h, "duplicate"), 2u);
}

TEST(TensorRate, AddsUpForRandomStreams) {
  std::mt19937 random(8);
  for (int round = 0; round < 40; ++round) {
    auto h = rate("framerate=" + std::to_string(1 + random() % 60) + "/1", "0/1");
    GstClockTime time = 0;
    for (int i = 0; i < 50; ++i) {
      time += random() % (150 * kMs);
      push(h, static_cast<uint8_t>(i), random() % 10 ? time : GST_CLOCK_TIME_NONE,
           random() % 5 ? 30 * kMs : GST_CLOCK_TIME_NONE);
    }
    gst_harness_push_event(h.get(), gst_event_new_eos());
    EXPECT_EQ(stat(h, kRate, "held"), 0u);
    expect_sums(h);
    EXPECT_EQ(pull_all(h).size(), counter(h, "out"));
  }
}

TEST(TensorRate, PassesAllFramesWithoutAFramerate) {
  auto h = rate("");
  GstBuffer* in = frame(Bytes{1}, 5, 6);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(out.get(), in);
  EXPECT_EQ(counter(h, "in"), 1u);
  EXPECT_EQ(counter(h, "out"), 1u);
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
}

std::vector<GstClockTimeDiff> throttles(const Harness& h) {
  std::vector<GstClockTimeDiff> out;
  while (auto e = Ref<GstEvent>::adopt(gst_harness_try_pull_upstream_event(h.get()))) {
    if (GST_EVENT_TYPE(e.get()) != GST_EVENT_QOS) continue;
    GstQOSType type{};
    gdouble proportion = 0;
    GstClockTimeDiff diff = 0;
    gst_event_parse_qos(e.get(), &type, &proportion, &diff, nullptr);
    EXPECT_EQ(type, GST_QOS_TYPE_THROTTLE);
    EXPECT_DOUBLE_EQ(proportion, 0.9);
    out.push_back(diff);
  }
  return out;
}

TEST(TensorRate, ThrottlesUpstreamToTheOutputRate) {
  const GstClockTimeDiff wait = 199'800'000;  // 0.999 of 200 ms
  auto h = rate("framerate=5/1");
  for (uint8_t i = 0; i < 5; ++i) push(h, i, i * 100 * kMs);
  EXPECT_EQ(throttles(h), std::vector<GstClockTimeDiff>(2, wait)) << "one for each frame dropped";
  auto quiet = rate("framerate=5/1 throttle=false");
  for (uint8_t i = 0; i < 5; ++i) push(quiet, i, i * 100 * kMs);
  EXPECT_TRUE(throttles(quiet).empty());
  auto same = rate("framerate=10/1");
  for (uint8_t i = 0; i < 5; ++i) push(same, i, i * 100 * kMs);
  EXPECT_EQ(throttles(same), std::vector<GstClockTimeDiff>(1, 99'900'000));
  EXPECT_EQ(pull_all(same).size(), 5u);
}

TEST(TensorRate, DropsABackwardsFrameAndWarns) {
  auto h = rate("framerate=20/1");
  Errors errors(h);
  push(h, 0, 100 * kMs);
  push(h, 1, 50 * kMs);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-2008: a timestamp goes backwards");
  push(h, 2, 60 * kMs);
  EXPECT_EQ(errors.next_warning(), "") << "posted only once";
  EXPECT_EQ(counter(h, "drop"), 2u);
  EXPECT_EQ(stat(h, kRate, "backwards-times"), 2u);
  EXPECT_EQ(stat(h, kRate, "dropped-time"), 2u);
  expect_sums(h);
}

TEST(TensorRate, FillsUpToTheEndOfTheSegment) {
  auto h = rate("framerate=10/1", "0/1");
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.stop = 500 * kMs;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  push(h, 7, 0);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(pull_all(h).size(), 5u);
  EXPECT_EQ(counter(h, "duplicate"), 4u);
  segment.stop = 1000 * GST_SECOND;
  auto long_one = rate("framerate=10/1", "0/1");
  gst_harness_push_event(long_one.get(), gst_event_new_segment(&segment));
  push(long_one, 7, 0);
  gst_harness_push_event(long_one.get(), gst_event_new_eos());
  EXPECT_EQ(pull_all(long_one).size(), 25u);
}

TEST(TensorRate, TheEndOfASegmentOfBytesIsNoTime) {
  auto h = rate("framerate=10/1", "0/1");
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_BYTES);
  segment.stop = 500 * kMs;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  push(h, 7, 0);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(pull_all(h), (std::vector<Out>{{7, 0}}));
}

struct Gap {
  GstClockTime time, duration;
  bool operator==(const Gap&) const = default;
};
std::ostream& operator<<(std::ostream& s, const Gap& g) {
  return s << g.duration << " from " << g.time;
}
std::vector<Gap> gaps(const Harness& h) {
  std::vector<Gap> out;
  while (auto e = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get()))) {
    if (GST_EVENT_TYPE(e.get()) != GST_EVENT_GAP) continue;
    auto& gap = out.emplace_back();
    gst_event_parse_gap(e.get(), &gap.time, &gap.duration);
  }
  return out;
}

TEST(TensorRate, SendsAGapEventForTheMiddleOfALongGap) {
  auto h = rate("framerate=10/1 max-duplication-time=300000000", "25/1");
  push(h, 1, 0);
  push(h, 2, 3600 * GST_SECOND);
  push(h, 3, 3600 * GST_SECOND + 100 * kMs);
  std::vector<Out> expected{{1, 0}, {1, 100 * kMs}, {1, 200 * kMs}, {1, 300 * kMs}};
  for (GstClockTime before : {300, 200, 100, 0})
    expected.push_back({2, 3600 * GST_SECOND - before * kMs});
  EXPECT_EQ(pull_all(h), expected);
  EXPECT_EQ(gaps(h), (std::vector<Gap>{{400 * kMs, 3600 * GST_SECOND - 700 * kMs}}));
  EXPECT_EQ(stat(h, kRate, "gap-events"), 1u);
  EXPECT_EQ(stat(h, kRate, "gap-ticks"), 36000u - 7);
  EXPECT_EQ(counter(h, "duplicate"), 6u);
  expect_sums(h);
}

TEST(TensorRate, FillsAGapOfTwoMinutesAndBoundsAGapOfAYear) {
  auto h = rate("framerate=10/1", "25/1");
  const GstClockTime year = 365 * 24 * 3600 * GST_SECOND;
  push(h, 1, 0);
  push(h, 2, 120 * GST_SECOND);
  push(h, 3, 120 * GST_SECOND + 100 * kMs);
  EXPECT_EQ(pull_all(h).size(), 1201u);
  EXPECT_EQ(gaps(h), std::vector<Gap>{});
  push(h, 4, year);
  push(h, 5, year + 100 * kMs);
  EXPECT_EQ(pull_all(h).size(), 1202u);
  EXPECT_EQ(gaps(h).size(), 1u);
  expect_sums(h);
}

TEST(TensorRate, FillsEveryGapWithoutALimit) {
  auto h = rate("framerate=1/1 max-duplication-time=0");
  push(h, 1, 0);
  push(h, 2, 3600 * GST_SECOND);
  EXPECT_EQ(pull_all(h).size(), 1801u);
  EXPECT_EQ(gaps(h), std::vector<Gap>{});
  EXPECT_EQ(stat(h, kRate, "gap-ticks"), 0u);
}

// Flushes while tensor_rate fills a gap on a thread that holds the pad's stream lock.
TEST(TensorRate, StopsFillingAGapAtAFlush) {
  auto h = rate("framerate=1000/1 max-duplication-time=0");
  struct Flush {
    int buffers = 0;
    GstPad* sink;
  } flush{
      0,
      Ref<GstPad>::adopt(gst_element_get_static_pad(find_element(h, kRate).get(), "sink")).get()};
  const auto source =
      Ref<GstPad>::adopt(gst_element_get_static_pad(find_element(h, kRate).get(), "src"));
  const auto probe = +[](GstPad*, GstPadProbeInfo*, gpointer data) {
    auto* f = static_cast<Flush*>(data);
    if (++f->buffers == 10) gst_pad_send_event(f->sink, gst_event_new_flush_start());
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(source.get(), GST_PAD_PROBE_TYPE_BUFFER, probe, &flush, nullptr);
  push(h, 1, 0);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{2}, 365 * 24 * 3600 * GST_SECOND)),
            GST_FLOW_FLUSHING);
  EXPECT_EQ(flush.buffers, 10);
  gst_pad_send_event(flush.sink, gst_event_new_flush_stop(TRUE));
  expect_sums(h);
}

TEST(TensorRate, DropsTimesBeyondTheClocksRange) {
  auto h = rate("framerate=10/1", "25/1");
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.base = 5;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  push(h, 1, 0);
  push(h, 2, GST_CLOCK_TIME_NONE - 3);
  EXPECT_EQ(stat(h, kRate, "dropped-time"), 1u);
  push(h, 3, GST_CLOCK_TIME_NONE - 7, GST_CLOCK_TIME_NONE - 1);
  push(h, 4, GST_CLOCK_TIME_NONE);
  EXPECT_EQ(stat(h, kRate, "dropped-time"), 2u) << "the previous frame has no end";
  expect_sums(h);
}

TEST(TensorRate, CountsFlushedFramesAndRestarts) {
  auto h = rate("framerate=5/1");
  push(h, 0, 1 * GST_SECOND);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  EXPECT_EQ(stat(h, kRate, "dropped-flush"), 1u);
  gst_harness_push_event(h.get(), time_segment());
  push(h, 1, 40 * kMs);
  push(h, 2, 340 * kMs);
  EXPECT_EQ(pull_all(h), (std::vector<Out>{{1, 40 * kMs}}));
}

TEST(TensorRate, SendsAHeldFrameWithItsOwnCaps) {
  auto h = rate("framerate=20/1");
  push(h, 9, 0);
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2", "10/1").c_str());
  EXPECT_EQ(pull_all(h), (std::vector<Out>{{9, 0}}));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2}, 100 * kMs)), GST_FLOW_OK);
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{3, 4}, 150 * kMs)), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{1, 2}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2,");
}

TEST(TensorRate, IgnoresAnUnreadableFramerateAndReportsThePosition) {
  const auto element = lone_element("tensor_rate framerate=10/1");
  Errors errors(element.get());
  g_object_set(element.get(), "framerate", "30/x", nullptr);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-1001: framerate cannot be read and is ignored");
  EXPECT_SAYS(warning, "    30/x\n       ^");
  gchar* text = nullptr;
  g_object_get(element.get(), "framerate", &text, nullptr);
  EXPECT_STREQ(text, "10/1");
  g_free(text);
  EXPECT_SAYS((gst_element_set_state(element.get(), GST_STATE_PAUSED), errors.next_warning()),
              "framerate cannot be read")
      << "it is posted when the pipeline starts";
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST(TensorRate, AppliesAnotherFramerateWhilePlaying) {
  auto h = rate("framerate=5/1");
  push(h, 0, 0);
  g_object_set(find_element(h, kRate).get(), "framerate", "20/1", nullptr);
  push(h, 1, 100 * kMs);
  push(h, 2, 200 * kMs);
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)20/1");
  expect_sums(h);
}

TEST(TensorRate, NotifiesWhenNotSilent) {
  auto h = rate("framerate=5/1 silent=false");
  int drops = 0;
  g_signal_connect(find_element(h, kRate).get(), "notify::drop",
                   G_CALLBACK(+[](GObject*, GParamSpec*, int* n) { ++*n; }), &drops);
  for (uint8_t i = 0; i < 5; ++i) push(h, i, i * 100 * kMs);
  EXPECT_EQ(drops, 2);
}

TEST(TensorRate, HoldsOneFrameOfLatency) {
  auto h = rate("framerate=30/1");
  gst_harness_set_upstream_latency(h.get(), 5 * kMs);
  EXPECT_EQ(gst_harness_query_latency(h.get()), 105 * kMs);
}

TEST(TensorRate, CarriesOneToTwentyTensors) {
  for (size_t count = 1; count <= 20; ++count) {
    std::string types = "uint8", dims = "2";
    for (size_t i = 1; i < count; ++i)
      types += ",uint8", dims += ",2:1:1:1:1:1:1:1:1:1:1:1:1:1:1:1";
    auto h = make_harness("tensor_rate framerate=20/1", tensors(types, dims, "10/1"));
    const Bytes bytes = ramp(2 * count);
    for (uint64_t i = 0; i < 2; ++i)
      ASSERT_EQ(gst_harness_push(h.get(), frame(bytes, i * 100 * kMs)), GST_FLOW_OK);
    auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(out.get()), bytes);
  }
}

}  // namespace tensor_rate_test
