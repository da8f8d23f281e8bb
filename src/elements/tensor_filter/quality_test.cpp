// QoS of tensor_filter: throttling, deadlines, reported latency.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/check/gsttestclock.h>

#include <cmath>
#include <fstream>

#include "elements/tensor_filter/admission.hpp"
#include "elements/tensor_filter/gated_filter_test_support.hpp"
#include "elements/tests/element_test_support.hpp"

namespace quality_test {

using namespace weir::test;

constexpr GstClockTime kMs = GST_MSECOND;
constexpr GstClockTime kNone = GST_CLOCK_TIME_NONE;
constexpr char kFilter[] = "tensor_filter";

std::string filter(const std::string& properties = "") {
  const std::string path = testing::TempDir() + "weir_quality_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=fake model=" + path + " " + properties;
}
Harness harness(const std::string& launch) {
  return make_harness(launch, tensors("float32", "4:1", "10/1"));
}
void push(const Harness& h, GstClockTime time, GstClockTime duration = 100 * kMs) {
  ASSERT_EQ(gst_harness_push(h.get(), frame<float>({1, 2, 3, 4}, time, duration)), GST_FLOW_OK);
}
std::vector<GstClockTime> times(const Harness& h) {
  std::vector<GstClockTime> out;
  while (auto b = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get())))
    out.push_back(GST_BUFFER_PTS(b.get()) / kMs);
  return out;
}
using Times = std::vector<GstClockTime>;

void throttle(const Harness& h, GstClockTimeDiff delay) {
  gst_harness_push_upstream_event(h.get(), gst_event_new_qos(GST_QOS_TYPE_THROTTLE, 0.9, delay, 0));
}
struct Qos {
  GstQOSType type;
  double proportion;
  GstClockTimeDiff difference;
  GstClockTime time;
  bool operator==(const Qos&) const = default;
};
std::vector<Qos> events_sent_upstream(const Harness& h) {
  std::vector<Qos> out;
  while (auto e = Ref<GstEvent>::adopt(gst_harness_try_pull_upstream_event(h.get()))) {
    if (GST_EVENT_TYPE(e.get()) != GST_EVENT_QOS) continue;
    auto& q = out.emplace_back();
    gst_event_parse_qos(e.get(), &q.type, &q.proportion, &q.difference, &q.time);
  }
  return out;
}
constexpr auto kOverflow = GST_QOS_TYPE_OVERFLOW;

TEST(TensorFilterThrottle, DropsFramesAboveTheRequestedRate) {
  auto h = harness(filter());
  push(h, 0);
  throttle(h, 200 * kMs);
  for (int i = 1; i < 7; ++i) push(h, i * 100 * kMs);
  EXPECT_EQ(times(h), (Times{0, 200, 400, 600}));
  EXPECT_EQ(stat(h, kFilter, "dropped-qos"), 3u);
  EXPECT_EQ(stat(h, kFilter, "invokes"), 4u) << "a dropped frame costs no invoke";
  EXPECT_EQ(stat(h, kFilter, "held"), 0u);
}

TEST(TensorFilterThrottle, SendsOverflowEventsUpstream) {
  auto h = harness(filter());
  push(h, 1000 * kMs);
  throttle(h, 200 * kMs);
  push(h, 1100 * kMs, 50 * kMs);
  push(h, 1200 * kMs);
  push(h, 1250 * kMs, GST_CLOCK_TIME_NONE);
  EXPECT_EQ(events_sent_upstream(h),
            (std::vector<Qos>{{kOverflow, 0.25, -100 * GstClockTimeDiff(kMs), 1100 * kMs},
                              {kOverflow, 0.25, -150 * GstClockTimeDiff(kMs), 1250 * kMs}}))
      << "the request itself is not forwarded";
}

// GStreamer rejects QoS events with a timestamp below 0.
TEST(TensorFilterThrottle, SendsNoTimeBelowZero) {
  auto h = harness(filter());
  push(h, 0);
  throttle(h, 200 * kMs);
  push(h, 20 * kMs);
  EXPECT_EQ(events_sent_upstream(h),
            (std::vector<Qos>{{kOverflow, 0.5, -20 * GstClockTimeDiff(kMs), 20 * kMs}}));
}

TEST(TensorFilterThrottle, EnablesLatencyMeasurement) {
  auto h = harness(filter());
  const auto latency = [&] {
    int value = 0;
    g_object_get(find_element(h, kFilter).get(), "latency", &value, nullptr);
    return value;
  };
  push(h, 0);
  push(h, 100 * kMs);
  EXPECT_EQ(latency(), -1);
  throttle(h, 1);
  EXPECT_GE(latency(), 0);
}

TEST(TensorFilterThrottle, ForwardsOtherEvents) {
  auto h = harness(filter());
  push(h, 0);
  gst_harness_push_upstream_event(
      h.get(), gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 1.5, 5 * kMs, 10 * kMs));
  throttle(h, 0);
  const auto events = events_sent_upstream(h);
  ASSERT_EQ(events.size(), 2u) << "a delay of 0 is no throttling";
  EXPECT_EQ(events[0], (Qos{GST_QOS_TYPE_UNDERFLOW, 1.5, 5 * GstClockTimeDiff(kMs), 10 * kMs}));
  push(h, 100 * kMs);
  EXPECT_EQ(times(h), (Times{0, 100}));
}

TEST(TensorFilterThrottle, AcceptsFramesWithoutATime) {
  auto h = harness(filter());
  push(h, 0);
  throttle(h, 200 * kMs);
  push(h, GST_CLOCK_TIME_NONE);
  push(h, 100 * kMs);
  EXPECT_EQ(times(h).size(), 2u);
}

TEST(TensorFilterThrottle, AcceptsTheFirstFrameAfterAFlush) {
  auto h = harness(filter());
  push(h, 0);
  throttle(h, 200 * kMs);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  for (int i = 1; i < 4; ++i) push(h, i * 100 * kMs);
  EXPECT_EQ(times(h), (Times{0, 100, 300}));
}

// Upstream of tensor_rate, which uses every second frame, only these are computed.
TEST(TensorFilterThrottle, ComputesOnlyFramesThatTensorRateNeeds) {
  constexpr int kFrames = 41;
  const auto invokes_and_out = [](const std::string& properties) {
    auto h = harness(filter() + " ! tensor_rate framerate=5/1 " + properties);
    for (int i = 0; i < kFrames; ++i) push(h, i * 100 * kMs);
    gst_harness_push_event(h.get(), gst_event_new_eos());
    EXPECT_EQ(stat(h, kFilter, "received"), guint64{kFrames});
    EXPECT_EQ(stat(h, kFilter, "received"),
              stat(h, kFilter, "consumed") + stat(h, kFilter, "dropped-qos"));
    return std::pair{stat(h, kFilter, "invokes"), times(h)};
  };
  const auto [all, expected] = invokes_and_out("throttle=false");
  EXPECT_EQ(all, guint64{kFrames});
  const auto [fewer, out] = invokes_and_out("throttle=true");
  EXPECT_EQ(out, expected);
  EXPECT_LE(fewer, kFrames / 2 + 2) << "one or two frames before the request arrives";
  EXPECT_EQ(out.size(), 21u);
}

// ---- Deadlines -------------------------------------------------------------------------------

GstTestClock* get_clock(const Harness& h) {
  return gst_harness_get_testclock(h.get());
}
void set_time(const Harness& h, GstClockTime time) {
  const Unique<GstTestClock, gst_object_unref> clock(get_clock(h));
  gst_test_clock_set_time(clock.get(), time);
}

TEST(TensorFilterDeadline, DropsALateFrameBeforeTheInvoke) {
  auto h = harness(filter("deadline=50000000"));
  set_time(h, 100 * kMs);
  push(h, 40 * kMs);  // until 90
  push(h, 49 * kMs);  // until 99
  push(h, 50 * kMs);  // until 100
  push(h, 60 * kMs);  // until 110
  EXPECT_EQ(times(h), (Times{50, 60}));
  EXPECT_EQ(stat(h, kFilter, "dropped-qos"), 2u);
  EXPECT_EQ(stat(h, kFilter, "invokes"), 2u);
  EXPECT_EQ(stat(h, kFilter, "held"), 0u);
}

TEST(TensorFilterDeadline, IsOffByDefaultAndCanChange) {
  auto h = harness(filter());
  set_time(h, 10 * GST_SECOND);
  push(h, 0);
  g_object_set(find_element(h, kFilter).get(), "deadline", guint64{kMs}, nullptr);
  push(h, 1 * kMs);
  g_object_set(find_element(h, kFilter).get(), "deadline", guint64{0}, nullptr);
  push(h, 2 * kMs);
  EXPECT_EQ(times(h), (Times{0, 2}));
}

TEST(TensorFilterDeadline, UsesTheRunningTime) {
  auto h = harness(filter("deadline=50000000"));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.start = segment.time = 1000 * kMs;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  set_time(h, 100 * kMs);
  push(h, 1049 * kMs);
  push(h, 1050 * kMs);
  EXPECT_EQ(times(h), (Times{1050}));
}

TEST(TensorFilterDeadline, IsNoneForAStreamWithoutTime) {
  auto h = harness(filter("deadline=1 qos=true"));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_BYTES);
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  set_time(h, 100 * kMs);
  push(h, 0);
  gst_harness_push_upstream_event(h.get(),
                                  gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 1.5, 5, 10 * kMs));
  throttle(h, 200 * kMs);
  push(h, 10 * kMs);
  push(h, 210 * kMs);
  EXPECT_EQ(times(h), (Times{0, 210})) << "the time between frames is still known";
}

TEST(TensorFilterDeadline, IsPassedToTheEngine) {
  auto h = harness(filter("deadline=50000000 custom=show-deadline:1"));
  push(h, 40 * kMs);
  const auto first = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(values<float>(first.get())[0], 90.f);
  push(h, GST_CLOCK_TIME_NONE);
  const auto timeless = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(values<float>(timeless.get())[0], -1.f) << "none";
}

// The clock passes the deadline of the last two frames while the first batch runs.
TEST(TensorFilterDeadline, DropsALateFrameBeforeItsBatchRuns) {
  GatedFilter filter("batch-size=2 batch-timeout=3600000000000 deadline=50000000");
  for (int i = 0; i < 4; ++i) ASSERT_EQ(filter.push(static_cast<float>(i)), GST_FLOW_OK);
  gate().wait_for_entered(1);
  const Unique<GstTestClock, gst_object_unref> clock(gst_harness_get_testclock(filter.get()));
  gst_test_clock_set_time(clock.get(), 200 * kMs);
  gate().open();
  EXPECT_EQ(filter.pull(2), (std::vector<float>{1, 2}));
  filter.expect_all_accounted();
  EXPECT_EQ(filter.stat("dropped-qos"), 2u);
  EXPECT_EQ(filter.stat("batches"), 1u);
}

TEST(TensorFilterDeadline, OfABatchIsPassedToTheEngine) {
  const std::string batch = "custom=show-expiry:1 batch-size=2 batch-timeout=3600000000000 ";
  for (const bool has : {true, false}) {
    auto h = harness(filter(batch + (has ? "deadline=3600000000000" : "")));
    push(h, 0);
    push(h, 100 * kMs);
    for (int i = 0; i < 2; ++i) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      EXPECT_EQ(values<float>(out.get())[0], has ? 1.F : 0.F);
    }
  }
}

TEST(TensorFilterDeadline, AcceptsTheMaximumValue) {
  auto h = harness(filter("deadline=" + std::to_string(INT64_MAX)));
  set_time(h, 100 * kMs);
  push(h, 0);
  push(h, INT64_MAX);
  EXPECT_EQ(times(h).size(), 2u);
}

TEST(TensorFilterDeadline, IsGivenToEnginesByTheMonotonicClock) {
  EXPECT_EQ(weir::monotonic_at(90, 40, 1000), 1050);
  EXPECT_EQ(weir::monotonic_at(40, 40, 1000), 1000);
  EXPECT_EQ(weir::monotonic_at(40, 90, 1000), 950);
  EXPECT_EQ(weir::monotonic_at(0, 999, 1000), 1);
  for (const GstClockTime past : {GstClockTime{1000}, GstClockTime{1001}, kNone - 1})
    EXPECT_EQ(weir::monotonic_at(0, past, 1000), 1) << past << ": 0 would mean that there is none";
  for (const GstClockTime far : {GstClockTime{INT64_MAX}, GstClockTime{INT64_MAX} + 1, kNone - 1})
    EXPECT_EQ(weir::monotonic_at(far, 0, 1000), INT64_MAX) << far;
  EXPECT_EQ(weir::monotonic_at(kNone - 1, INT64_MAX, 1000), INT64_MAX);
  EXPECT_EQ(weir::monotonic_at(INT64_MAX, 1000, 999), INT64_MAX - 1);
}

// ---- Latency ---------------------------------------------------------------------------------

std::pair<GstClockTime, GstClockTime> queried(const Harness& h) {
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_latency());
  EXPECT_TRUE(gst_pad_peer_query(h->sinkpad, query.get()));
  GstClockTime min = 0, max = 0;
  gst_query_parse_latency(query.get(), nullptr, &min, &max);
  return {min, max};
}

TEST(TensorFilterLatency, IsNotReportedByDefault) {
  auto h = harness(filter());
  gst_harness_set_upstream_latency(h.get(), 7 * kMs);
  push(h, 0);
  push(h, 100 * kMs);
  EXPECT_EQ(queried(h).first, 7 * kMs);
}

TEST(TensorFilterLatency, AddsTheMeanWithAMarginToTheUpstreamLatency) {
  auto h = harness(filter("latency-report=true latency=1"));
  gst_harness_set_upstream_latency(h.get(), 7 * kMs);
  push(h, 0);
  EXPECT_EQ(queried(h).first, 7 * kMs) << "the first invoke is not counted";
  for (int i = 1; i < 4; ++i) push(h, i * 100 * kMs);
  int mean_us = -1;
  g_object_get(find_element(h, kFilter).get(), "latency", &mean_us, nullptr);
  const auto [min, max] = queried(h);
  EXPECT_GT(min, 7 * kMs);
  EXPECT_EQ(max, kNone) << "the upstream source sets no limit";
  const double own_us = static_cast<double>(min - 7 * kMs) / 1e3;
  EXPECT_LE(std::abs(own_us - 1.05 * mean_us), 0.53) << "the property is rounded";
}

TEST(TensorFilterLatency, AddsToTheMaximumLatency) {
  auto h = harness(filter("latency-report=true"));
  const auto handle_query = [](GstPad*, GstPadProbeInfo* info, gpointer) {
    GstQuery* query = GST_PAD_PROBE_INFO_QUERY(info);
    if (GST_QUERY_TYPE(query) != GST_QUERY_LATENCY) return GST_PAD_PROBE_OK;
    gst_query_set_latency(query, TRUE, 3 * kMs, 9 * kMs);
    return GST_PAD_PROBE_HANDLED;
  };
  gst_pad_add_probe(h->srcpad, GstPadProbeType(GST_PAD_PROBE_TYPE_QUERY_UPSTREAM), handle_query,
                    nullptr, nullptr);
  push(h, 0);
  push(h, 100 * kMs);
  const auto [min, max] = queried(h);
  EXPECT_GT(min, 3 * kMs);
  EXPECT_EQ(min - 3 * kMs, max - 9 * kMs);
}

guint latency_messages(GstBus* bus) {
  guint count = 0;
  while (auto m = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus, GST_MESSAGE_LATENCY))) ++count;
  return count;
}

TEST(TensorFilterLatency, PostsAMessageWhenItChanges) {
  for (const bool on : {true, false}) {
    auto h = harness(filter(on ? "latency-report=true" : ""));
    const auto bus = Ref<GstBus>::adopt(gst_bus_new());
    gst_element_set_bus(find_element(h, kFilter).get(), bus.get());
    push(h, 0);
    EXPECT_EQ(latency_messages(bus.get()), 0u) << "no latency is known";
    push(h, 100 * kMs);
    EXPECT_EQ(latency_messages(bus.get()), on ? 1u : 0u);
    gst_element_set_bus(find_element(h, kFilter).get(), nullptr);
  }
}

}  // namespace quality_test
