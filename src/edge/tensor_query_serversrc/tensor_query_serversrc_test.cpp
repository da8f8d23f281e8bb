// tensor_query_serversrc with a client over a real connection: requests become frames, and every
// call ends.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <cstring>
#include <string>
#include <thread>

#include "becomes.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "net/client/link.hpp"
#include "net/protocol/oip_contents.hpp"
#include "net/protocol/outcome.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::test {
namespace tensor_query_serversrc_test {

using namespace std::chrono_literals;
using net::Link;
using Floats = std::array<float, 4>;

std::string source(const std::string& options) {
  return "tensor_query_serversrc name=server protocol=oip port=0 model-name=m " + options +
         " caps=other/tensor,dimension=(string)4:1,type=(string)float32,framerate=0/1 ! ";
}

class TensorQueryServersrc : public ::testing::Test {
 protected:
  void play(const std::string& rest, const std::string& options = "") {
    play_line(source(options) + rest);
  }
  void play_line(const std::string& line) {
    pipeline_ = std::make_unique<PlayedPipeline>(line);
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_PLAYING));
    connect();
  }
  void connect() {
    ASSERT_NE(port(), 0u);
    const auto address =
        net::ServerAddress::parse("grpc://127.0.0.1:" + std::to_string(port()) + "/m");
    auto link = Link::open(*address, {}, 1 << 20);
    ASSERT_TRUE(link);
    link_ = *std::move(link);
    ASSERT_TRUE(becomes_true([this] { return is_ready(); }, "a model that is ready"));
  }
  guint port() const {
    guint port = 0;
    g_object_get(pipeline_->find("server").get(), "port", &port, nullptr);
    return port;
  }
  bool is_ready() {
    const auto reply = link_->call("ModelReady", net::encode_model_request("m", ""), nullptr,
                                   Link::Clock::now() + 30s);
    const auto ready = net::parse_model_ready(reply.chunks);
    return ready && *ready;
  }
  net::Reply infer(const Floats& values, const char* type = "FP32",
                   Link::Clock::duration time = 30s) {
    static constexpr int64_t kShape[] = {1, 4};
    const net::RequestTensor tensor{"input", type, kShape, std::as_bytes(std::span(values))};
    uint64_t copied = 0;
    const auto request =
        net::encode_infer_request("m", "", {&tensor, 1}, net::Contents::Raw, false, &copied);
    return link_->call("ModelInfer", *request, nullptr, Link::Clock::now() + time);
  }
  static Floats result_of(const net::Reply& reply) {
    Floats out{};
    const auto response = net::parse_infer_response(reply.chunks);
    EXPECT_TRUE(response && response->outputs.size() == 1) << reply.message;
    if (!response || response->outputs.size() != 1) return out;
    EXPECT_TRUE(net::read_elements(reply.chunks, response->outputs[0],
                                   std::as_writable_bytes(std::span(out)), net::Sender::Server));
    return out;
  }
  uint64_t stat(const char* name) const { return pipeline_->stat("server", name); }

  std::unique_ptr<PlayedPipeline> pipeline_;
  std::unique_ptr<Link> link_;
};

TEST_F(TensorQueryServersrc, AnswersWithWhatThePipelineMakes) {
  play("tensor_transform mode=arithmetic option=mul:2,add:1 ! tensor_query_serversink name=end");
  for (float i = 0; i < 20; ++i)
    EXPECT_EQ(result_of(infer({i, 1, -1, 0.5})), (Floats{2 * i + 1, 3, -1, 2}));
  EXPECT_EQ(stat("requests-received"), 20u);
  EXPECT_EQ(stat("requests-answered"), 20u);
  EXPECT_EQ(stat("requests-in-flight"), 0u);
  EXPECT_EQ(stat("received"), 20u);
  EXPECT_EQ(stat("consumed"), 20u);
  EXPECT_EQ(pipeline_->stat("end", "bytes-copied"), 0u);
}

TEST_F(TensorQueryServersrc, RefusesAnotherType) {
  play("tensor_query_serversink");
  const auto reply = infer({}, "INT32");
  EXPECT_EQ(reply.status, static_cast<int>(net::CallStatus::InvalidArgument));
  EXPECT_SAYS(reply.message, "offered: input INT32 [1,4]");
  EXPECT_SAYS(reply.message, "needed: input FP32 [1,4]");
  EXPECT_EQ(stat("requests-refused"), 1u);
}

TEST_F(TensorQueryServersrc, NamesTheElementThatDropped) {
  play("identity name=gate drop-probability=1 ! tensor_query_serversink");
  const auto reply = infer({});
  EXPECT_EQ(reply.status, static_cast<int>(net::CallStatus::Aborted));
  EXPECT_EQ(reply.message, "dropped by gate");
  EXPECT_EQ(stat("requests-aborted"), 1u);
}

TEST_F(TensorQueryServersrc, RefusesARequestThatWaitedWhileTheCapsChanged) {
  const auto caps = [](const char* number, const char* dimensions, const char* types) {
    return std::string("other/tensors,format=static,num_tensors=") + number +
           ",dimensions=(string)" + dimensions + ",types=(string)" + types + ",framerate=0/1";
  };
  play_line(
      "tensor_query_serversrc name=server protocol=oip port=0 model-name=m ! "
      "capsfilter name=wanted caps=" +
      caps("1", "4:1", "float32") + " ! identity name=gate ! tensor_query_serversink");
  const auto gate =
      Ref<GstPad>::adopt(gst_element_get_static_pad(pipeline_->find("gate").get(), "sink"));
  const auto blocks = GstPadProbeType(GST_PAD_PROBE_TYPE_BLOCK | GST_PAD_PROBE_TYPE_BUFFER);
  const gulong block = gst_pad_add_probe(
      gate.get(), blocks, +[](GstPad*, GstPadProbeInfo*, gpointer) { return GST_PAD_PROBE_OK; },
      nullptr, nullptr);
  net::Reply first, second;
  std::thread first_caller([&] { first = infer({1, 2, 3, 4}); });
  EXPECT_TRUE(becomes_true([&] { return gst_pad_is_blocking(gate.get()); }, "a frame on its way"));
  std::thread second_caller([&] { second = infer({}); });
  EXPECT_TRUE(becomes_true([&] { return stat("requests-in-flight") == 2; }, "a waiting request"));
  const auto other =
      Ref<GstCaps>::adopt(gst_caps_from_string(caps("2", "4:1.2:1", "float32.float32").c_str()));
  g_object_set(pipeline_->find("wanted").get(), "caps", other.get(), nullptr);
  gst_pad_remove_probe(gate.get(), block);
  first_caller.join();
  second_caller.join();
  EXPECT_EQ(result_of(first), (Floats{1, 2, 3, 4}));
  EXPECT_EQ(second.status, static_cast<int>(net::CallStatus::InvalidArgument));
  EXPECT_SAYS(second.message, "the inputs of the model m changed while the request waited");
  EXPECT_EQ(stat("requests-refused"), 1u);
}

TEST_F(TensorQueryServersrc, EndsCallsWhenItStops) {
  play("tensor_query_serversink");
  ASSERT_TRUE(pipeline_->reaches(GST_STATE_PAUSED));
  net::Reply waiting;
  std::thread caller([&] { waiting = infer({}); });
  EXPECT_TRUE(becomes_true([&] { return stat("requests-in-flight") == 1; }, "a waiting request"));
  EXPECT_TRUE(pipeline_->reaches(GST_STATE_NULL));
  caller.join();
  EXPECT_EQ(waiting.status, static_cast<int>(net::CallStatus::Unavailable));
  EXPECT_EQ(waiting.message, "the pipeline of the model m was stopped");
}

TEST_F(TensorQueryServersrc, RefusesCallsAfterTheEndOfItsStream) {
  play("tensor_query_serversink", "num-buffers=1");
  EXPECT_EQ(infer({}).status, 0);
  EXPECT_EQ(pipeline_->outcome(), "");
  const auto reply = infer({});
  EXPECT_EQ(reply.status, static_cast<int>(net::CallStatus::Unavailable));
  EXPECT_SAYS(reply.message, "the pipeline of the model m");
}

TEST_F(TensorQueryServersrc, ServesAgainAfterAStop) {
  for (int i = 0; i < 3; ++i) {
    play("tensor_query_serversink");
    EXPECT_EQ(result_of(infer({1, 2, 3, 4})), (Floats{1, 2, 3, 4}));
  }
}

TEST_F(TensorQueryServersrc, GivesItsPortBackWhenItStops) {
  for (const GstState state : {GST_STATE_READY, GST_STATE_NULL}) {
    play("tensor_query_serversink");
    const guint was = port();
    EXPECT_EQ(infer({}).status, 0);
    ASSERT_TRUE(pipeline_->reaches(state));
    EXPECT_TRUE(edge::listen_on("localhost", was));
    EXPECT_EQ(stat("requests-answered"), 1u);
    EXPECT_EQ(stat("calls-refused"), 0u);
  }
}

TEST_F(TensorQueryServersrc, ServesAgainOnItsPortWithOtherSettings) {
  play("tensor_query_serversink");
  for (const guint64 max : {2048, 4096}) {
    const guint was = port();
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_NULL));
    g_object_set(pipeline_->find("server").get(), "port", was, "max-message", max, nullptr);
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_PLAYING));
    EXPECT_EQ(port(), was);
    connect();
    EXPECT_EQ(result_of(infer({1, 2, 3, 4})), (Floats{1, 2, 3, 4}));
  }
}

// The sink of the edge server gets the frame before that of the server which received the request.
TEST_F(TensorQueryServersrc, IsNotAnsweredByTheSinkOfAnotherProtocol) {
  play(
      "tee name=both ! tensor_query_serversink both. ! tensor_query_serversink id=1 "
      "tensor_query_serversrc port=0 ! other/tensor,dimension=(string)4:1,type=(string)float32,"
      "framerate=0/1 ! fakesink async=false",
      "id=1");
  infer({});
  const std::string error = pipeline_->outcome();
  EXPECT_SAYS(error,
              "WEIR-1004: frames arrive that answer requests of a server with another protocol");
  EXPECT_SAYS(error,
              "offered: at tensor_query_serversink id=0: requests of tensor_query_serversrc id=1");
  EXPECT_SAYS(error, "fix: tensor_query_serversink id=1 for these frames");
}

TEST_F(TensorQueryServersrc, RejectsSettingsThatItCannotUse) {
  const std::string sink = "tensor_query_serversink";
  EXPECT_SAYS(error_of_pipeline(source("connect-type=HYBRID") + sink), "does not use a broker");
  EXPECT_SAYS(error_of_pipeline(source("host=0.0.0.0") + sink), "WEIR-6003");
  EXPECT_SAYS(error_of_pipeline(source("tls-key=key.pem") + sink), "tls-key without tls-cert");
  EXPECT_SAYS(error_of_pipeline("tensor_query_serversrc protocol=oip port=0 ! fakesink"),
              "WEIR-1004: the tensors of the requests are not known");
}

}  // namespace tensor_query_serversrc_test
}  // namespace weir::test
