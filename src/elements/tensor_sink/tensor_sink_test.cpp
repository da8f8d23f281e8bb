// tensor_sink in a harness: signals, their rate, accepted and rejected input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/check/gsttestclock.h>

#include <string>
#include <vector>

#include "elements/tests/element_test_support.hpp"

namespace tensor_sink_test {

using namespace weir::test;

constexpr char kBytes[] = "other/tensor,dimension=(string)2,type=uint8,framerate=30/1";

struct Received {
  std::vector<std::vector<uint8_t>> frames;
  int starts = 0, ends = 0;
};

class TensorSink : public ::testing::Test {
 protected:
  void make(const std::string& properties, const char* caps = kBytes) {
    h_ = Harness{gst_harness_new_parse(("tensor_sink " + properties).c_str())};
    element_ = Ref<GstElement>::adopt(gst_harness_find_element(h_.get(), "tensor_sink"));
    const auto on_data = +[](GstElement*, GstBuffer* b, Received* r) {
      const Mapped map(b, GST_MAP_READ);
      const auto bytes = map.as<const uint8_t>();
      r->frames.emplace_back(bytes.begin(), bytes.end());
    };
    g_signal_connect(element_.get(), "new-data", G_CALLBACK(on_data), &received_);
    g_signal_connect(element_.get(), "stream-start",
                     G_CALLBACK(+[](GstElement*, Received* r) { ++r->starts; }), &received_);
    g_signal_connect(element_.get(), "eos",
                     G_CALLBACK(+[](GstElement*, Received* r) { ++r->ends; }), &received_);
    gst_harness_set_src_caps_str(h_.get(), caps);
  }
  GstFlowReturn push(uint8_t a, uint8_t b) {
    GstBuffer* buffer = gst_buffer_new_allocate(nullptr, 2, nullptr);
    const uint8_t bytes[] = {a, b};
    gst_buffer_fill(buffer, 0, bytes, 2);
    return gst_harness_push(h_.get(), buffer);
  }
  uint64_t stat(const char* name) { return weir::test::stat(element_.get(), name); }

  Harness h_;
  Ref<GstElement> element_;
  Received received_;
};

TEST_F(TensorSink, EmitsEachFrameInOrder) {
  make("");
  EXPECT_EQ(push(1, 2), GST_FLOW_OK);
  EXPECT_EQ(push(3, 4), GST_FLOW_OK);
  EXPECT_EQ(received_.frames, (std::vector<std::vector<uint8_t>>{{1, 2}, {3, 4}}));
  EXPECT_EQ(stat("received"), 2u);
  EXPECT_EQ(stat("consumed"), 2u);
  EXPECT_EQ(stat("not-signalled"), 0u);
}

TEST_F(TensorSink, EmitsStreamStartAndEos) {
  make("");
  push(1, 2);
  EXPECT_EQ(received_.starts, 1);
  EXPECT_EQ(received_.ends, 0);
  gst_harness_push_event(h_.get(), gst_event_new_eos());
  EXPECT_EQ(received_.ends, 1);
}

TEST_F(TensorSink, IsSilentWithoutEmitSignal) {
  make("emit-signal=false");
  EXPECT_EQ(push(1, 2), GST_FLOW_OK);
  gst_harness_push_event(h_.get(), gst_event_new_eos());
  EXPECT_TRUE(received_.frames.empty());
  EXPECT_EQ(received_.ends, 0);
  EXPECT_EQ(stat("consumed"), 1u);
  EXPECT_EQ(stat("not-signalled"), 1u);
}

// 10 signals per second = 100 ms apart, by the pipeline's clock.
TEST_F(TensorSink, LimitsTheRateByTheClock) {
  make("signal-rate=10");
  gst_harness_use_testclock(h_.get());
  auto clock = Ref<GstTestClock>::adopt(gst_harness_get_testclock(h_.get()));
  const GstClockTime start = gst_clock_get_time(GST_CLOCK_CAST(clock.get()));
  for (uint8_t i = 0; i < 30; ++i) {
    gst_test_clock_set_time(clock.get(), start + i * 10 * GST_MSECOND);
    EXPECT_EQ(push(i, 0), GST_FLOW_OK);
  }
  EXPECT_EQ(received_.frames, (std::vector<std::vector<uint8_t>>{{0, 0}, {10, 0}, {20, 0}}));
  EXPECT_EQ(stat("not-signalled"), 27u);
}

TEST_F(TensorSink, StartsWithTheDocumentedValues) {
  make("");
  guint rate = 1;
  gboolean sync = TRUE, qos = FALSE, emit = FALSE;
  gint64 lateness = 0;
  g_object_get(element_.get(), "signal-rate", &rate, "sync", &sync, "qos", &qos, "emit-signal",
               &emit, "max-lateness", &lateness, nullptr);
  EXPECT_EQ(rate, 0u);
  EXPECT_FALSE(sync);
  EXPECT_TRUE(qos);
  EXPECT_TRUE(emit);
  EXPECT_EQ(lateness, -1);
}

TEST_F(TensorSink, CannotSeek) {
  make("");
  push(1, 2);
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_seeking(GST_FORMAT_TIME));
  EXPECT_TRUE(gst_pad_peer_query(h_->srcpad, query.get()));
  gboolean seekable = TRUE;
  gst_query_parse_seeking(query.get(), nullptr, &seekable, nullptr, nullptr);
  EXPECT_FALSE(seekable);
}

TEST_F(TensorSink, AcceptsFlexibleAndSparseStreams) {
  for (const char* format : {"flexible", "sparse"}) {
    received_ = {};
    make("", (std::string("other/tensors,framerate=30/1,format=") + format).c_str());
    EXPECT_EQ(push(1, 2), GST_FLOW_OK) << format;
    EXPECT_EQ(received_.frames.size(), 1u) << format;
  }
}

TEST_F(TensorSink, RejectsCapsThatAreNotTensors) {
  make("", "video/x-raw,format=RGB,width=1,height=1,framerate=30/1");
  EXPECT_EQ(push(1, 2), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_TRUE(received_.frames.empty());
}

TEST_F(TensorSink, KeepsTheRateWithinItsRange) {
  make("");
  auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element_.get()), "signal-rate");
  EXPECT_EQ(G_PARAM_SPEC_UINT(spec)->maximum, 500u);
}

}  // namespace tensor_sink_test
