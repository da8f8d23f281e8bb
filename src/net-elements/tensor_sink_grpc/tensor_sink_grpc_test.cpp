// tensor_sink_grpc with tensor_src_grpc at the other end of a real connection: both roles, both
// schemas, what is dropped, what fails.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "net-elements/grpc_test_support.hpp"

namespace weir::test {
namespace tensor_sink_grpc_test {

constexpr char kSink[] = "tensor_sink_grpc", kSource[] = "tensor_src_grpc";

Harness served_source(const std::string& options = "") {
  Harness h = make_harness("tensor_src_grpc port=0 " + options);
  gst_harness_play(h.get());
  return h;
}
Harness served_sink(const std::string& options = "") {
  return make_harness("tensor_sink_grpc server=true port=0 sync=false " + options, kSixBytes);
}
Harness make_source(const Harness& sink, const std::string& options = "") {
  Harness h = make_harness("tensor_src_grpc server=false " + options + get_port(sink, kSink));
  gst_harness_play(h.get());
  return h;
}
// A port of this machine on which nothing listens.
std::string free_port() {
  return get_port(served_source(), kSource);
}

// docs/compatibility/programs.md 11.2.
TEST(GrpcHost, KeepsTheOneBeforeATextThatIsNone) {
  for (const char* factory : {kSink, kSource}) {
    const auto element = lone_element(factory);
    Errors errors(element.get());
    for (const auto& [text, taken] :
         {std::pair{"invalid host", "localhost"}, {"box.lan", "box.lan"}, {"a b", "box.lan"}}) {
      g_object_set(element.get(), "host", text, nullptr);
      gchar* host = nullptr;
      g_object_get(element.get(), "host", &host, nullptr);
      EXPECT_STREQ(gst::UniqueText(host).get(), taken) << factory;
    }
    EXPECT_SAYS(errors.next_warning(), "host cannot be a host name or an address");
  }
}

class TensorSinkGrpc : public ::testing::TestWithParam<const char*> {
 protected:
  const std::string idl_ = std::string(" idl=") + GetParam();
};
INSTANTIATE_TEST_SUITE_P(Schemas, TensorSinkGrpc, ::testing::Values("protobuf", "flatbuf"));

TEST_P(TensorSinkGrpc, SendsEachFrameToAServer) {
  const Harness source = served_source(idl_);
  const Harness sink =
      make_harness("tensor_sink_grpc sync=false" + idl_ + get_port(source, kSource), kSixBytes);
  for (uint8_t i = 0; i < 3; ++i)
    EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(i)), GST_FLOW_OK);
  for (uint8_t i = 0; i < 3; ++i) {
    const Bytes wanted{
        i, uint8_t(i + 1), uint8_t(i + 2), uint8_t(i + 3), uint8_t(i + 4), uint8_t(i + 5)};
    EXPECT_EQ(pulled_bytes(source), wanted);
  }
  const std::string caps = caps_text(source);
  EXPECT_SAYS(caps, "num_tensors=(int)2");
  EXPECT_SAYS(caps, "types=(string)\"uint8\\,uint8\"");
  EXPECT_SAYS(caps, "framerate=(fraction)5/1");
  guint out = 0;
  g_object_get(find_element(sink, kSink).get(), "out", &out, nullptr);
  EXPECT_EQ(out, 3u);
  EXPECT_EQ(stat(sink, kSink, "held"), 0u);
}

TEST_P(TensorSinkGrpc, ServesEachFrameToEachClient) {
  const Harness sink = served_sink(idl_);
  const Harness one = make_source(sink, idl_), other = make_source(sink, idl_);
  ASSERT_TRUE(wait_for_stat(sink, kSink, "peers", 2));
  for (uint8_t i = 0; i < 5; ++i)
    EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(i)), GST_FLOW_OK);
  for (uint8_t i = 0; i < 5; ++i) {
    EXPECT_EQ(pulled_bytes(one)[0], i);
    EXPECT_EQ(pulled_bytes(other)[0], i);
  }
  EXPECT_TRUE(wait_for_stat(sink, kSink, "messages-sent", 10));
}

TEST_P(TensorSinkGrpc, ItsEosIsThatOfItsClients) {
  const Harness sink = served_sink(idl_);
  const Harness source = make_source(sink, idl_);
  gst_harness_push(sink.get(), six_bytes(1));
  EXPECT_TRUE(gst_harness_push_event(sink.get(), gst_event_new_eos()));
  EXPECT_EQ(pulled_bytes(source)[0], 1u) << "what was queued is sent first";
  EXPECT_TRUE(ends(source));
}

TEST(TensorSinkGrpcAlone, SendsWhatIsQueuedBeforeTheEnd) {
  const Harness source = served_source("queue=100");
  const Harness sink =
      make_harness("tensor_sink_grpc sync=false" + get_port(source, kSource), kSixBytes);
  for (int i = 0; i < 50; ++i) gst_harness_push(sink.get(), six_bytes(0));
  EXPECT_TRUE(gst_harness_push_event(sink.get(), gst_event_new_eos()));
  EXPECT_EQ(stat(sink, kSink, "messages-sent"), 50u);
  EXPECT_EQ(stat(sink, kSink, "peers"), 0u) << "the call has ended";
  for (int i = 0; i < 50; ++i) EXPECT_EQ(pulled_bytes(source).size(), 6u);
}

// As by a seek to the beginning.
void end_and_flush(const Harness& sink) {
  EXPECT_TRUE(gst_harness_push_event(sink.get(), gst_event_new_eos()));
  EXPECT_EQ(stat(sink, kSink, "peers"), 0u) << "the calls have ended";
  gst_harness_push_event(sink.get(), gst_event_new_flush_start());
  gst_harness_push_event(sink.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(sink.get(), time_segment());
}

TEST(TensorSinkGrpcAlone, SendsToItsServerAgainAfterTheEndAndAFlush) {
  const Harness source = served_source();
  const Harness sink = make_harness(
      "tensor_sink_grpc sync=false blocking=false" + get_port(source, kSource), kSixBytes);
  for (const uint8_t first : {1, 7}) {
    EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(first)), GST_FLOW_OK);
    ASSERT_EQ(stat(sink, kSink, "dropped-policy"), 0u);
    EXPECT_EQ(pulled_bytes(source)[0], first);
    end_and_flush(sink);
  }
}

TEST(TensorSinkGrpcAlone, ServesNewClientsAfterTheEndAndAFlush) {
  const Harness sink = served_sink();
  for (const uint8_t first : {1, 7}) {
    const Harness source = make_source(sink);
    ASSERT_TRUE(wait_for_stat(sink, kSink, "peers", 1));
    EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(first)), GST_FLOW_OK);
    EXPECT_EQ(pulled_bytes(source)[0], first);
    end_and_flush(sink);
    EXPECT_TRUE(ends(source));
  }
}

TEST(TensorSinkGrpcAlone, WithoutBlockingDropsWhatNoServerTakes) {
  const Harness sink =
      make_harness("tensor_sink_grpc sync=false blocking=false queue=2" + free_port(), kSixBytes);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(0)), GST_FLOW_OK);
  EXPECT_EQ(stat(sink, kSink, "dropped-policy"), 3u);
  EXPECT_EQ(stat(sink, kSink, "consumed"), 2u);
}

TEST(TensorSinkGrpcAlone, SendsToAServerThatComesLater) {
  const std::string port = free_port();
  const Harness sink = make_harness("tensor_sink_grpc sync=false" + port, kSixBytes);
  EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(7)), GST_FLOW_OK);
  const Harness source = make_harness("tensor_src_grpc" + port);
  gst_harness_play(source.get());
  EXPECT_EQ(pulled_bytes(source)[0], 7u);
}

TEST(TensorSinkGrpcAlone, ConnectsAgain) {
  const std::string port = free_port();
  Harness first = make_harness("tensor_src_grpc" + port);
  gst_harness_play(first.get());
  const Harness sink = make_harness("tensor_sink_grpc sync=false" + port, kSixBytes);
  gst_harness_push(sink.get(), six_bytes(1));
  EXPECT_EQ(pulled_bytes(first)[0], 1u);
  ASSERT_TRUE(wait_for_stat(sink, kSink, "messages-sent", 1));
  first.reset();
  ASSERT_TRUE(wait_for_stat(sink, kSink, "peers", 0));
  const Harness second = make_harness("tensor_src_grpc" + port);
  gst_harness_play(second.get());
  gst_harness_push(sink.get(), six_bytes(2));
  EXPECT_EQ(pulled_bytes(second)[0], 2u);
  EXPECT_EQ(stat(sink, kSink, "messages-lost"), 0u);
}

TEST(TensorSinkGrpcAlone, WarnsOnceThatNoServerAnswers) {
  const Harness sink = make_harness("tensor_sink_grpc sync=false" + free_port());
  Errors errors(sink);
  std::string warning;
  ASSERT_TRUE(
      becomes_true([&] { return !(warning = errors.next_warning()).empty(); }, "a warning"));
  EXPECT_SAYS(warning, "WEIR-6001: the server localhost:");
  EXPECT_SAYS(warning, "cannot be reached; the element tries again until it can");
  EXPECT_SAYS(warning, "tensor_src_grpc server=true");
}

TEST(TensorSinkGrpcAlone, ReportsAServerOfAnotherSchema) {
  const Harness source = served_source("idl=flatbuf");
  const Harness sink =
      make_harness("tensor_sink_grpc sync=false" + get_port(source, kSource), kSixBytes);
  Errors errors(sink);
  std::string error;
  ASSERT_TRUE(becomes_true(
      [&] {
        gst_harness_push(sink.get(), six_bytes(0));
        return !(error = errors.next()).empty();
      },
      "an error"));
  EXPECT_SAYS(error, "WEIR-6002: the server localhost:");
  EXPECT_SAYS(error, "offered: /nnstreamer.protobuf.TensorService/SendTensors");
  EXPECT_SAYS(error, "has the method /nnstreamer.flatbuf.TensorService/SendTensors only");
}

TEST(TensorSinkGrpcAlone, ReportsAFrameThatIsTooLarge) {
  const std::string caps =
      "other/tensor,dimension=(string)2000,type=(string)uint8,framerate=(fraction)0/1";
  const Harness sink =
      make_harness("tensor_sink_grpc sync=false max-message=1024" + free_port(), caps);
  Errors errors(sink);
  EXPECT_EQ(gst_harness_push(sink.get(), frame(Bytes(2000))), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "WEIR-2006: a frame is larger than the largest message");
  EXPECT_SAYS(error, "needed: at most 1024 bytes (max-message)");
  EXPECT_SAYS(error, "fix: max-message=20");
  EXPECT_EQ(stat(sink, kSink, "dropped-error"), 1u);
}

TEST(TensorSinkGrpcAlone, ReportsPropertiesThatCannotBeUsed) {
  const std::string schema = start_error("tensor_sink_grpc idl=capnproto");
  EXPECT_SAYS(schema, "WEIR-1004: the schema of the messages is unknown");
  EXPECT_SAYS(schema, "offered: idl=capnproto");
  EXPECT_SAYS(schema, "needed: protobuf or flatbuf");
  const Harness source = served_source();
  const std::string port = start_error("tensor_sink_grpc server=true" + get_port(source, kSource));
  EXPECT_SAYS(port, "WEIR-1004: the server cannot listen on this address");
  EXPECT_SAYS(port, "fix: port=0");
  EXPECT_SAYS(start_error("tensor_sink_grpc server=true host=no.such.name.invalid"), "WEIR-1004");
  EXPECT_SAYS(start_error("tensor_sink_grpc allow=1.2.3"), "an entry of the property allow");
  EXPECT_SAYS(start_error("tensor_sink_grpc allow=192.0.2.0/24"),
              "the property allow does not name the server");
}

TEST(TensorSinkGrpcAlone, StopsWhileItWaitsForAServer) {
  PlayedPipeline pipeline(
      "videotestsrc ! video/x-raw,format=GRAY8,width=4,height=4 ! tensor_converter ! "
      "tensor_sink_grpc name=sink sync=false queue=1" +
      free_port());
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  ASSERT_TRUE(wait_for_stat(pipeline.find("sink").get(), "received", 2));
  EXPECT_TRUE(pipeline.reaches(GST_STATE_NULL));
  EXPECT_EQ(pipeline.stat("sink", "held"), 0u);
}

TEST(TensorSinkGrpcAlone, PausingWhileItWaitsForRoomLosesAndRepeatsNothing) {
  const std::string port = free_port();
  const Harness sink = make_harness("tensor_sink_grpc sync=false queue=1" + port, kSixBytes);
  EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(1)), GST_FLOW_OK);
  std::thread writer([&] { EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(2)), GST_FLOW_OK); });
  EXPECT_TRUE(wait_for_stat(sink, kSink, "received", 2));
  const auto element = find_element(sink, kSink);
  for (int i = 0; i < 200; ++i) {  // some before the thread that waits has woken
    gst_element_set_state(element.get(), GST_STATE_PAUSED);
    gst_element_set_state(element.get(), GST_STATE_PLAYING);
  }
  const Harness source = make_harness("tensor_src_grpc" + port);
  gst_harness_play(source.get());
  writer.join();
  EXPECT_EQ(pulled_bytes(source), Bytes({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(pulled_bytes(source), Bytes({2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(stat(sink, kSink, "consumed"), 2u);
}

TEST(TensorSinkGrpcAlone, ServesOnlyWhomItAllows) {
  const Harness sink = served_sink("allow=192.0.2.0/24");
  const Harness source = make_harness("tensor_src_grpc server=false" + get_port(sink, kSink));
  Errors errors(source);
  gst_harness_play(source.get());
  std::string error;
  ASSERT_TRUE(becomes_true([&] { return !(error = errors.next()).empty(); }, "an error"));
  EXPECT_SAYS(error, "this server does not allow your address (allow)");
}

TEST(TensorSinkGrpcAlone, ServesSoManyConnections) {
  for (const std::string limit : {"max-connections", "max-connections-per-address"}) {
    const Harness sink = served_sink(limit + "=1");
    const Harness source = make_source(sink);
    ASSERT_TRUE(wait_for_stat(sink, kSink, "peers", 1));
    const Harness other = make_harness("tensor_src_grpc server=false" + get_port(sink, kSink));
    Errors errors(other);
    gst_harness_play(other.get());
    std::string error;
    ASSERT_TRUE(becomes_true([&] { return !(error = errors.next()).empty(); }, "an error"));
    EXPECT_SAYS(error, "(" + limit + ")");
    EXPECT_EQ(gst_harness_push(sink.get(), six_bytes(1)), GST_FLOW_OK);
    EXPECT_EQ(pulled_bytes(source)[0], 1u) << "the first one is served";
  }
}

TEST(TensorSinkGrpcAlone, ServesManyConnectionsWithoutALimit) {
  const Harness sink = served_sink("max-connections=0 max-connections-per-address=0");
  std::vector<Harness> sources;
  for (int i = 0; i < 33; ++i) sources.push_back(make_source(sink));
  EXPECT_TRUE(wait_for_stat(sink, kSink, "peers", 33));
}

}  // namespace tensor_sink_grpc_test
}  // namespace weir::test
