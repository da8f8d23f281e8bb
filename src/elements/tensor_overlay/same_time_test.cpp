// sync=same-time: pictures wait for their own results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <functional>
#include <thread>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_overlay/overlay_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"

namespace weir::overlay_test {
namespace same_time_test {

constexpr const char* kLong = "sync=same-time max-wait=86400000000000";

TEST(SameTime, DrawsTheResultsOfTheSameRunningTime) {
  const Both b(kLong);
  GstSegment segment;  // 100 s of this stream have running time 0
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.start = segment.time = 100 * GST_SECOND;
  gst_harness_push_event(b.results.get(), gst_event_new_segment(&segment));
  for (const float i : {0.f, 1.f, 2.f})
    b.push({i, 0, 8, 6, 1, 0}, (100 + static_cast<GstClockTime>(i)) * GST_SECOND);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{0, 0, 8, 6}}));
  EXPECT_EQ(b.picture(kSmall, 2 * GST_SECOND), small_with({{2, 0, 8, 6}}));
  EXPECT_EQ(b.stat("results-drawn"), 2u);
  EXPECT_EQ(b.stat("results-unused"), 1u);
  b.expect_results_balance();
}

TEST(SameTime, WaitsForResultsOfAnotherThread) {
  const Both b(kLong);
  std::thread other([&] {
    for (int i = 0; i < 200; ++i)
      if (i % 4 != 3) b.push({float(i % 3), 0, 8, 6, 1, 0}, static_cast<GstClockTime>(i) * 1000);
    gst_harness_push_event(b.results.get(), gst_event_new_eos());
  });
  for (int i = 0; i < 200; ++i) {
    const auto out = b.picture(kSmall, static_cast<GstClockTime>(i) * 1000);
    EXPECT_EQ(out, i % 4 == 3 ? Bytes(kSmall) : small_with({{i % 3, 0, 8, 6}})) << i;
  }
  other.join();
  EXPECT_EQ(b.stat("results-drawn"), 150u);
  EXPECT_EQ(b.stat("results-late"), 0u);
  EXPECT_EQ(b.stat("pushed"), 200u);
  b.expect_results_balance();
}

TEST(SameTime, WarnsOnceOfATeeWithoutAQueue) {
  const std::string source =
      "videotestsrc num-buffers=2 ! video/x-raw,format=BGRx,width=8,height=1,framerate=30/1 ! ";
  const std::string branches =
      "o.sink  t. ! tensor_converter name=made ! tensor_transform name=boxes mode=typecast "
      "option=float32 ! o.results  tensor_overlay name=o sync=same-time max-wait=1 ! fakesink";
  const test::PlayedPipeline graph(source + "tee name=t  t. ! " + branches);
  const std::string warning = graph.first_warning();
  EXPECT_SAYS(warning, "WEIR-5001: one thread feeds two pads that wait for each other");
  EXPECT_SAYS(warning, "t. ! queue ! o.sink   t. ! queue ! made ! boxes ! o.results");
}

TEST(SameTime, ContinuesWithoutResultsAfterTheWait) {
  const Both b("sync=same-time max-wait=1");
  EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
  EXPECT_EQ(b.stat("results-late"), 1u);
  b.push({0, 0, 8, 6, 1, 0}, 0);  // too late
  EXPECT_EQ(b.picture(kSmall, GST_CLOCK_TIME_NONE), Bytes(kSmall));
  gst_harness_push_event(b.results.get(), gst_event_new_gap(0, 2 * GST_SECOND));
  EXPECT_EQ(b.picture(kSmall, GST_SECOND), Bytes(kSmall));
  EXPECT_EQ(b.stat("results-late"), 1u);  // the GAP means that there are none
  EXPECT_EQ(b.stat("results-unused"), 1u);
  b.expect_results_balance();
}

TEST(SameTime, StopsWaitingWhenResultsEnd) {
  const Both b(kLong);
  gst_harness_push_event(b.results.get(), gst_event_new_eos());
  EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
}

// A picture that waits on another thread, and what ends the wait.
void expect_let_go(const std::function<void(const Both&)>& by) {
  const Both b(kLong);
  std::thread pictures([&] {
    EXPECT_EQ(gst_harness_push(b.pictures.get(), timed(frame(Bytes(kSmall)), 0)),
              GST_FLOW_FLUSHING);
  });
  test::wait_for_stat(b.element.get(), "received", 1);
  by(b);
  pictures.join();
}

TEST(SameTime, ReleasesAWaitingPictureOnStop) {
  expect_let_go([](const Both& b) { gst_element_set_state(b.element.get(), GST_STATE_NULL); });
}

TEST(SameTime, ReleasesAWaitingPictureOnFlush) {
  expect_let_go(
      [](const Both& b) { gst_harness_push_event(b.pictures.get(), gst_event_new_flush_start()); });
}

TEST(SameTime, PushesAWaitingPictureWhenTheResultsAreFlushed) {
  const Both b(kLong);
  std::thread pictures([&] { EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall)); });
  test::wait_for_stat(b.element.get(), "received", 1);
  gst_harness_push_event(b.results.get(), gst_event_new_flush_start());
  pictures.join();
  EXPECT_EQ(b.picture(kSmall, 1), Bytes(kSmall));
  gst_harness_push_event(b.results.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(b.results.get(), time_segment());
  b.push({0, 0, 8, 6, 1, 0}, 2);
  EXPECT_EQ(b.picture(kSmall, 2), small_with({{0, 0, 8, 6}}));
  b.expect_results_balance();
}

TEST(SameTime, AcceptsFlexibleStreams) {
  const Both b(kLong, video("RGB", 8, 6), "other/tensors,format=flexible,framerate=10/1");
  TensorHeader header;
  header.spec = {ElementType::Float32, {5, 2}, ""};
  std::vector<std::byte> bytes(kTensorHeaderBytes + 2 * 20);
  write_tensor_header(header, std::span(bytes).first<kTensorHeaderBytes>());
  const float numbers[] = {0, 0, 3, 3, 1, 4, 0, 8, 6, 0.5f};
  std::memcpy(bytes.data() + kTensorHeaderBytes, numbers, sizeof(numbers));
  ASSERT_EQ(gst_harness_push(b.results.get(), frame(bytes, 0)), GST_FLOW_OK);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{0, 0, 3, 3}, {4, 0, 8, 6}}));
}

// A harness answers like a live source.
GstClockTime latency(const std::string& properties) {
  const Both b(properties);
  gst_harness_set_upstream_latency(b.pictures.get(), GST_SECOND);
  return gst_harness_query_latency(b.pictures.get());
}

TEST(SameTime, AddsItsWaitToTheLatencyOfLiveStreams) {
  EXPECT_EQ(latency("sync=same-time max-wait=7"), GST_SECOND + 7);
  EXPECT_EQ(latency("max-wait=7"), GST_SECOND);
}

}  // namespace same_time_test
}  // namespace weir::overlay_test
