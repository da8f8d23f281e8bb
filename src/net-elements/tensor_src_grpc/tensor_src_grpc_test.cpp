// tensor_src_grpc with tensor_sink_grpc at the other end of a real connection: times, caps, ends,
// clients whose messages cannot be used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/flushed_start_test_support.hpp"
#include "net-elements/grpc_test_support.hpp"

namespace weir::test {
namespace tensor_src_grpc_test {

constexpr char kSink[] = "tensor_sink_grpc", kSource[] = "tensor_src_grpc";

Harness sink_to(const Harness& source, const std::string& caps) {
  return make_harness("tensor_sink_grpc sync=false" + get_port(source, kSource), caps);
}

TEST(TensorSrcGrpc, FramesHaveTheRunningTimeOfTheirArrival) {
  const Harness source = make_harness("tensor_src_grpc port=0");
  gst_harness_use_testclock(source.get());
  gst_harness_play(source.get());
  const GstClockTime base = gst_element_get_base_time(source->element);
  gst_harness_set_time(source.get(), base + 7 * GST_SECOND);
  const Harness sink = sink_to(source, kSixBytes);
  gst_harness_push(sink.get(), six_bytes(0));
  const auto buffer = Ref<GstBuffer>::adopt(gst_harness_pull(source.get()));
  ASSERT_TRUE(buffer);
  EXPECT_EQ(GST_BUFFER_PTS(buffer.get()), 7 * GST_SECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(buffer.get()), GST_SECOND / 5);
  EXPECT_EQ(gst_buffer_n_memory(buffer.get()), 2u);
}

TEST(TensorSrcGrpc, CapsChangeWithTheMessages) {
  const Harness source = make_harness("tensor_src_grpc port=0");
  gst_harness_play(source.get());
  const Harness sink = sink_to(
      source, "other/tensor,dimension=(string)4:2,type=(string)int16,framerate=(fraction)0/1");
  gst_harness_push(sink.get(), frame(Bytes(16, 1)));
  EXPECT_EQ(pulled_bytes(source), Bytes(16, 1));
  EXPECT_SAYS(caps_text(source), "int16");
  gst_harness_set_src_caps_str(
      sink.get(), "other/tensor,dimension=(string)2,type=(string)float64,framerate=(fraction)0/1");
  gst_harness_push(sink.get(), frame(Bytes(16, 2)));
  EXPECT_EQ(pulled_bytes(source), Bytes(16, 2));
  EXPECT_SAYS(caps_text(source), "float64");
}

TEST(TensorSrcGrpc, RefusesTheClientWhoseCapsDownstreamRejects) {
  const Harness source = make_harness("tensor_src_grpc port=0");
  gst_harness_set_sink_caps_str(source.get(), kSixBytes.c_str());
  gst_harness_play(source.get());
  const Harness bad = sink_to(
      source, "other/tensor,dimension=(string)4,type=(string)uint8,framerate=(fraction)5/1");
  Errors errors(bad);
  std::string error;
  ASSERT_TRUE(becomes_true(
      [&] {
        gst_harness_push(bad.get(), frame(Bytes(4)));
        return !(error = errors.next()).empty();
      },
      "the refusal"));
  EXPECT_SAYS(error, "WEIR-6002: the server localhost:");
  EXPECT_SAYS(error, "WEIR-2001");
  EXPECT_SAYS(error, "dimensions=(string)4, types=(string)uint8");
  EXPECT_TRUE(wait_for_stat(source, kSource, "peers", 0));
  const Harness good = sink_to(source, kSixBytes);
  gst_harness_push(good.get(), six_bytes(3));
  EXPECT_EQ(pulled_bytes(source)[0], 3u) << "the others go on";
  EXPECT_GE(stat(source, kSource, "messages-refused"), 1u);
  EXPECT_EQ(stat(source, kSource, "held"), 0u);
}

TEST(TensorSrcGrpc, SeveralClientsSendToOneStream) {
  const Harness source = make_harness("tensor_src_grpc port=0");
  gst_harness_play(source.get());
  const Harness one = sink_to(source, kSixBytes), other = sink_to(source, kSixBytes);
  for (int i = 0; i < 4; ++i) {
    gst_harness_push(one.get(), six_bytes(1));
    gst_harness_push(other.get(), six_bytes(2));
  }
  int sum = 0;
  for (int i = 0; i < 8; ++i) sum += pulled_bytes(source)[0];
  EXPECT_EQ(sum, 4 + 8);
}

TEST(TensorSrcGrpc, EndsAfterNumBuffers) {
  const Harness source = make_harness("tensor_src_grpc port=0 num-buffers=2");
  gst_harness_play(source.get());
  const Harness sink = sink_to(source, kSixBytes);
  for (int i = 0; i < 2; ++i) gst_harness_push(sink.get(), six_bytes(0));
  EXPECT_TRUE(ends(source));
  guint out = 0;
  g_object_get(find_element(source, kSource).get(), "out", &out, nullptr);
  EXPECT_EQ(out, 2u);
}

TEST(TensorSrcGrpc, TheEndOfAClientIsNotTheEndOfTheServer) {
  const Harness source = make_harness("tensor_src_grpc port=0");
  gst_harness_play(source.get());
  {
    const Harness first = sink_to(source, kSixBytes);
    gst_harness_push(first.get(), six_bytes(1));
    gst_harness_push_event(first.get(), gst_event_new_eos());
  }
  const Harness second = sink_to(source, kSixBytes);
  gst_harness_push(second.get(), six_bytes(2));
  EXPECT_EQ(pulled_bytes(source)[0], 1u);
  EXPECT_EQ(pulled_bytes(source)[0], 2u);
}

TEST(TensorSrcGrpc, StopsWhileItWaits) {
  for (const char* options : {"port=0", "server=false port=1"}) {
    PlayedPipeline pipeline(std::string("tensor_src_grpc ") + options + " ! fakesink");
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    EXPECT_TRUE(pipeline.reaches(GST_STATE_PAUSED));
    EXPECT_TRUE(pipeline.reaches(GST_STATE_NULL));
  }
}

TEST(TensorSrcGrpc, StartsWhileItIsFlushed) {
  start_while_flushed("tensor_src_grpc port=0");
}

TEST(TensorSrcGrpc, ShowsTheWantedPortAgainAfterTheStop) {
  const auto source = lone_element("tensor_src_grpc port=0");
  const auto port = [&] {
    gint out = -1;
    g_object_get(source.get(), "port", &out, nullptr);
    return out;
  };
  gst_element_set_state(source.get(), GST_STATE_PAUSED);
  EXPECT_GT(port(), 0);
  gst_element_set_state(source.get(), GST_STATE_NULL);
  EXPECT_EQ(port(), 0);
}

TEST(TensorSrcGrpc, WarnsThatOtherMachinesCanConnect) {
  const auto source = lone_element("tensor_src_grpc port=0 host=0.0.0.0");
  Errors errors(source.get());
  gst_element_set_state(source.get(), GST_STATE_PAUSED);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-6003");
  EXPECT_SAYS(warning, "listening on 0.0.0.0:0");
  EXPECT_SAYS(warning, "fix: host=127.0.0.1");
  gst_element_set_state(source.get(), GST_STATE_NULL);
}

TEST(TensorSrcGrpc, ObeysTheRuleForTls) {
  g_setenv("WEIR_NETWORK_REQUIRE_TLS", "true", TRUE);
  const std::string error = start_error("tensor_src_grpc port=0 host=0.0.0.0");
  const std::string allowed =
      start_error("tensor_src_grpc port=0 host=0.0.0.0 insecure=true allow=127.0.0.0/8");
  const std::string local = start_error("tensor_src_grpc port=0");
  g_unsetenv("WEIR_NETWORK_REQUIRE_TLS");
  EXPECT_SAYS(error, "WEIR-6003");
  EXPECT_SAYS(error, "insecure=true allow=");
  EXPECT_EQ(allowed, "");
  EXPECT_EQ(local, "");
}

TEST(TensorSrcGrpc, ReportsAnUnknownSchema) {
  EXPECT_SAYS(start_error("tensor_src_grpc idl=json"),
              "WEIR-1004: the schema of the messages is unknown");
}

}  // namespace tensor_src_grpc_test
}  // namespace weir::test
