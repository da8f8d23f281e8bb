// edgesink and edgesrc over TCP: many tensors, frames that do not match, addresses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "transport/edge/stream_publisher.hpp"
#include "transport/edge/stream_subscriber.hpp"

namespace edge_tcp_test {

using namespace weir::test;

guint get_port(const Harness& sink) {
  guint port = 0;
  gst_structure_get_uint(stats(find_element(sink, "edgesink").get()).get(), "port", &port);
  return port;
}
std::string listed(const std::string& item, int count) {
  std::string out = item;
  for (int i = 1; i < count; ++i) out += "," + item;
  return out;
}

// 20 tensors of one byte in one memory: edgesink sends one memory each.
TEST(EdgeTcp, MoreThan16TensorsTravelAsAMemoryEach) {
  const auto out = make_harness("edgesink sync=false port=0 wait-connection=true",
                                tensors(listed("uint8", 20), listed("1", 20)));
  auto subscriber = weir::edge::StreamSubscriber::connect("localhost", get_port(out), {});
  ASSERT_TRUE(subscriber);
  ASSERT_EQ(gst_harness_push(out.get(), frame(ramp(20))), GST_FLOW_OK);
  const auto received = subscriber->receive();
  ASSERT_TRUE(received && !received->end);
  ASSERT_EQ(received->memories.size(), 20u);
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(received->memories[i].bytes()[0], static_cast<std::byte>(i));
}

TEST(EdgeTcp, MoreThan16TensorsArePackedAgain) {
  const auto out = make_harness("edgesink sync=false port=0 wait-connection=true",
                                tensors(listed("uint8", 20), listed("1", 20)));
  Harness in{gst_harness_new_parse(("edgesrc dest-port=" + std::to_string(get_port(out))).c_str())};
  gst_harness_play(in.get());
  ASSERT_EQ(gst_harness_push(out.get(), frame(ramp(20))), GST_FLOW_OK);
  const auto got = Ref<GstBuffer>::adopt(gst_harness_pull(in.get()));
  ASSERT_TRUE(got);
  EXPECT_EQ(gst_buffer_n_memory(got.get()), 16u);
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(in->sinkpad));
  const auto spec = weir::gst::spec_from_caps(caps.get());
  ASSERT_TRUE(spec);
  weir::gst::FrameLayout reader;
  ASSERT_TRUE(reader.read(got.get(), *spec));
  ASSERT_EQ(reader.tensors().size(), 20u);
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(reader.tensors()[i].payload[0], static_cast<std::byte>(i)) << i;
  EXPECT_EQ(stat(in, "edgesrc", "bytes-copied"), 5u);
}

TEST(EdgeTcp, WaitsForAReceiverAgainAfterReady) {
  const auto out =
      make_harness("edgesink sync=false port=0 wait-connection=true", tensors("uint8", "1"));
  const auto sink = find_element(out, "edgesink");
  const auto connect = [&] {
    return weir::edge::StreamSubscriber::connect("localhost", get_port(out), {});
  };
  {
    auto subscriber = connect();
    ASSERT_TRUE(subscriber);
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1})), GST_FLOW_OK);
    ASSERT_TRUE(subscriber->receive());
  }
  const auto receivers = [&] {
    guint count = 1;
    gst_structure_get_uint(stats(sink.get()).get(), "receivers", &count);
    return count;
  };
  ASSERT_TRUE(becomes_true([&] { return receivers() == 0; }, "no receiver"));
  gst_element_set_state(sink.get(), GST_STATE_READY);
  gst_element_set_state(sink.get(), GST_STATE_PLAYING);
  gst_harness_push_event(out.get(), gst_event_new_stream_start("again"));
  gst_harness_set_src_caps_str(out.get(), tensors("uint8", "1").c_str());
  std::jthread pushing([&] { gst_harness_push(out.get(), frame(Bytes{2})); });
  ASSERT_TRUE(wait_for_stat(sink.get(), "received", 2));
  auto subscriber = connect();
  ASSERT_TRUE(subscriber);
  pushing.join();
  ASSERT_EQ(stat(sink.get(), "consumed"), 2u);
  const auto received = subscriber->receive();
  ASSERT_TRUE(received && !received->end);
  EXPECT_EQ(received->memories[0].bytes()[0], std::byte{2});
}

// An edgesrc that waits for the caps of `sink`, which has none yet.
Harness early_source(const Harness& sink, const std::string& more = "") {
  Harness in{gst_harness_new_parse(
      ("edgesrc dest-port=" + std::to_string(get_port(sink)) + " " + more).c_str())};
  gst_harness_play(in.get());
  return in;
}

TEST(EdgeTcp, AReceiverThatConnectsBeforeTheCapsGetsThemAndEveryFrame) {
  const auto out = make_harness("edgesink sync=false port=0 wait-connection=true");
  const auto in = early_source(out);
  gst_harness_set_src_caps_str(out.get(), video("RGB", 2, 1).c_str());
  for (uint8_t i = 0; i < 3; ++i)
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{i, 0, 0, 0, 0, 0, 0, 0})), GST_FLOW_OK);
  for (uint8_t i = 0; i < 3; ++i) {
    const auto got = Ref<GstBuffer>::adopt(gst_harness_pull(in.get()));
    ASSERT_TRUE(got);
    EXPECT_EQ(content(got.get())[0], i);
  }
  EXPECT_SAYS(caps_text(in), "video/x-raw");
  EXPECT_SAYS(caps_text(in), "width=(int)2");
}

TEST(EdgeTcp, AReceiverOfAStreamWithoutCapsIsShownACapsfilterThatFits) {
  for (const auto& [downstream, fix] :
       {std::pair("videoconvert", "fix: edgesrc ! video/x-raw,format=RGB,width=640"),
        std::pair("audioconvert", "fix: edgesrc ! audio/x-raw,format=S16LE"),
        std::pair("tensor_converter ! tensor_sink", "fix: edgesrc ! other/tensors"),
        std::pair("fakesink", "fix: edgesrc ! CAPS")}) {
    const auto out = make_harness("edgesink sync=false port=0 wait-connection=true");
    const auto pipeline =
        lone_element("edgesrc dest-port=" + std::to_string(get_port(out)) + " ! " + downstream);
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    gst_harness_push_event(out.get(), gst_event_new_stream_start("test"));
    gst_harness_push_event(out.get(), time_segment());
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4})), GST_FLOW_OK);
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
    const auto message = Ref<GstMessage>::adopt(
        gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND, GST_MESSAGE_ERROR));
    EXPECT_SAYS(get_text(message.get()), "an edgesink that did not announce its caps");
    EXPECT_SAYS(get_text(message.get()), fix);
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }
}

TEST(EdgeTcp, EitherEndStopsAtOnceWhileAReceiverWaitsForTheCaps) {
  const auto out = make_harness("edgesink sync=false port=0");
  auto in = early_source(out);
  in.reset();
  const auto next = early_source(out);
  Errors errors(next);
  gst_element_set_state(find_element(out, "edgesink").get(), GST_STATE_NULL);
  std::string error;
  EXPECT_TRUE(becomes_true([&] { return !(error = errors.next()).empty(); }, "an error"));
  EXPECT_SAYS(error, "it closed the connection");
}

TEST(EdgeTcp, AReceiverThatReconnectsWaitsForTheCapsOfTheNextEdgesink) {
  auto out = make_harness("edgesink sync=false port=0");
  const guint port = get_port(out);
  const auto in = early_source(out, "reconnect=true");
  out.reset();
  out = make_harness("edgesink sync=false wait-connection=true port=" + std::to_string(port));
  gst_harness_set_src_caps_str(out.get(), tensors("uint8", "4").c_str());
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4})), GST_FLOW_OK);
  const auto got = Ref<GstBuffer>::adopt(gst_harness_pull(in.get()));
  ASSERT_TRUE(got);
  EXPECT_EQ(content(got.get()), (Bytes{1, 2, 3, 4}));
}

// The receiver does not read until the test does.
TEST(EdgeTcp, AReceiverThatMissesBuffersIsAWarningOnceUntilItHasCaughtUp) {
  const auto out = make_harness("edgesink sync=false port=0 wait-connection=true max-buffers=2",
                                "application/octet-stream");
  Errors errors(out);
  auto receiver = weir::edge::StreamSubscriber::connect("localhost", get_port(out), {});
  ASSERT_TRUE(receiver);
  // Larger than what the sockets buffer.
  const auto large = Ref<GstBuffer>::adopt(frame(Bytes(16 << 20)));
  uint64_t received = 0;
  for (uint64_t outage = 1; outage <= 2; ++outage) {
    const uint64_t before = stat(out, "edgesink", "missed");
    while (stat(out, "edgesink", "missed") < before + 3)
      ASSERT_EQ(gst_harness_push(out.get(), gst_buffer_ref(large.get())), GST_FLOW_OK);
    const std::string warning = errors.next_warning();
    EXPECT_SAYS(warning, "a receiver is slower than the stream, and misses buffers");
    EXPECT_SAYS(warning, "127.0.0.1: 2 buffers wait for it (max-buffers), " +
                             std::to_string(before + 1) + " dropped so far");
    EXPECT_SAYS(warning, "fix: edgesink max-buffers=96");
    EXPECT_EQ(errors.next_warning(), "");
    while (received < stat(out, "edgesink", "consumed")) {
      const auto got = receiver->receive();
      ASSERT_TRUE(got && !got->end);
      ++received;
    }
  }
}

// A server that sends frames of `count` flexible tensors, the i-th of i + 1 bytes.
class FlexibleFrames : public ::testing::Test {
 protected:
  FlexibleFrames() {
    auto publisher = weir::edge::StreamPublisher::open(
        {.host = "localhost", .port = 0, .queue = {}, .allowed = {}, .refused = {}});
    EXPECT_TRUE(publisher);
    publisher_ = *std::move(publisher);
    EXPECT_TRUE(publisher_->set_caps("other/tensors,format=flexible,framerate=10/1"));
    in_.reset(
        gst_harness_new_parse(("edgesrc dest-port=" + std::to_string(publisher_->port())).c_str()));
    gst_harness_play(in_.get());
    EXPECT_TRUE(publisher_->wait_for_subscriber(std::nullopt));
  }
  // With `wrong`, a header that declares one byte less than there are.
  void send(size_t count, std::optional<size_t> wrong = {}) {
    constexpr size_t kHeader = weir::kTensorHeaderBytes;
    tensors_.clear();
    for (uint32_t i = 0; i < count; ++i) {
      auto& tensor = tensors_.emplace_back(kHeader + i + 1, std::byte(i));
      const uint32_t declared = i + 1 - (wrong == i ? 1 : 0);
      weir::write_tensor_header({{weir::ElementType::UInt8, weir::Shape{declared}, ""},
                                 weir::Format::Static,
                                 weir::MediaType::Tensor,
                                 0},
                                std::span(tensor).first<kHeader>());
    }
    EXPECT_TRUE(publisher_->publish({tensors_.begin(), tensors_.end()}, nullptr));
    EXPECT_TRUE(publisher_->flush(std::nullopt));
  }

  std::vector<std::vector<std::byte>> tensors_;
  std::unique_ptr<weir::edge::StreamPublisher> publisher_;
  Harness in_;
};

TEST_F(FlexibleFrames, MoreThan16TensorsArePacked) {
  for (const size_t count : {16u, 17u, 40u, 255u}) {
    send(count);
    const auto got = Ref<GstBuffer>::adopt(gst_harness_pull(in_.get()));
    ASSERT_TRUE(got);
    EXPECT_EQ(gst_buffer_n_memory(got.get()), 16u);
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(in_->sinkpad));
    const auto spec = weir::gst::spec_from_caps(caps.get());
    ASSERT_TRUE(spec);
    weir::gst::FrameLayout reader;
    ASSERT_TRUE(reader.read(got.get(), *spec));
    ASSERT_EQ(reader.tensors().size(), count);
    for (size_t i = 0; i < count; ++i) {
      const auto& tensor = reader.tensors()[i];
      ASSERT_EQ(tensor.payload.size(), i + 1);
      EXPECT_EQ(tensor.payload[i], static_cast<std::byte>(i));
    }
  }
}

TEST_F(FlexibleFrames, APackedTensorWithAWrongHeaderIsAnError) {
  Errors errors(in_);
  send(20, 18);
  std::string error;
  EXPECT_TRUE(becomes_true([&] { return !(error = errors.next()).empty(); }, "an error"));
  EXPECT_SAYS(error, "does not have the size that its header declares");
}

// The first buffer arrives in PAUSED, when the pipeline has no clock.
TEST(EdgeTcp, DoTimestampGivesEveryBufferATime) {
  auto publisher = weir::edge::StreamPublisher::open(
      {.host = "localhost", .port = 0, .queue = {}, .allowed = {}, .refused = {}});
  ASSERT_TRUE(publisher);
  ASSERT_TRUE((*publisher)->set_caps(tensors("uint8", "4")));
  const auto pipeline = lone_element(
      "edgesrc do-timestamp=true num-buffers=3 dest-port=" + std::to_string((*publisher)->port()) +
      " ! fakesink name=out sync=false signal-handoffs=true");
  std::vector<GstClockTime> times;
  const auto sink = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  const auto keep = +[](GstElement*, GstBuffer* buffer, GstPad*, std::vector<GstClockTime>* out) {
    out->push_back(GST_BUFFER_PTS(buffer));
  };
  g_signal_connect(sink.get(), "handoff", G_CALLBACK(keep), &times);
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  EXPECT_TRUE((*publisher)->wait_for_subscriber(std::nullopt));
  const auto bytes = std::make_shared<std::vector<std::byte>>(4);
  EXPECT_TRUE((*publisher)->publish({*bytes}, bytes));
  EXPECT_EQ(gst_element_get_state(pipeline.get(), nullptr, nullptr, 60 * GST_SECOND),
            GST_STATE_CHANGE_SUCCESS);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  for (int i = 0; i < 2; ++i) EXPECT_TRUE((*publisher)->publish({*bytes}, bytes));
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  EXPECT_TRUE(Ref<GstMessage>::adopt(
      gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND, GST_MESSAGE_EOS)));
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  ASSERT_EQ(times.size(), 3u);
  EXPECT_EQ(times[0], 0u);
  EXPECT_TRUE(GST_CLOCK_TIME_IS_VALID(times[1]) && GST_CLOCK_TIME_IS_VALID(times[2]));
  EXPECT_LE(times[1], times[2]);
}

// docs/compatibility/edge-wire.md 10.6, class 9.
class UnlikeItsCaps : public ::testing::Test {
 protected:
  std::string error_of(const std::vector<size_t>& sizes) {
    auto publisher = weir::edge::StreamPublisher::open(
        {.host = "localhost", .port = 0, .queue = {}, .allowed = {}, .refused = {}});
    EXPECT_TRUE(publisher);
    EXPECT_TRUE((*publisher)->set_caps(tensors("uint8,uint8", "4,3")));
    const auto pipeline =
        lone_element("edgesrc dest-port=" + std::to_string((*publisher)->port()) + " ! fakesink");
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    EXPECT_TRUE((*publisher)->wait_for_subscriber(std::nullopt));
    const std::vector<std::byte> bytes(16);
    std::vector<std::span<const std::byte>> parts;
    for (const size_t size : sizes) parts.push_back(std::span(bytes).first(size));
    EXPECT_TRUE((*publisher)->publish(parts, nullptr));
    EXPECT_TRUE((*publisher)->flush(std::nullopt));
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
    const auto message = Ref<GstMessage>::adopt(
        gst_bus_timed_pop_filtered(bus.get(), 60 * GST_SECOND, GST_MESSAGE_ERROR));
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
    return get_text(message.get());
  }
};

TEST_F(UnlikeItsCaps, AFrameWithAnotherSizeIsAnError) {
  const std::string error = error_of({4, 4});
  EXPECT_SAYS(error, "does not match the caps");
  EXPECT_SAYS(error, "2 memories of 4,4 bytes");
  EXPECT_SAYS(error, "as tensor 1");
}
TEST_F(UnlikeItsCaps, AFrameWithMoreThan16MemoriesIsAnError) {
  EXPECT_SAYS(error_of(std::vector<size_t>(17, 1)), "17 memories of 1,1,");
}

TEST(EdgeTcp, AnAddressThatIsTakenIsNamed) {
  const auto out = make_harness("edgesink port=0");
  EXPECT_SAYS(start_error("edgesink port=" + std::to_string(get_port(out))), "in use");
  EXPECT_SAYS(start_error("edgesink port=" + std::to_string(get_port(out))), "port=0");
}

TEST(EdgeTcp, OtherMachinesAreAWarning) {
  const auto element = lone_element("edgesink host=0.0.0.0 port=0");
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_READY);
  EXPECT_SAYS(errors.next_warning(), "other machines can connect without encryption");
  gst_element_set_state(element.get(), GST_STATE_NULL);
  EXPECT_SAYS(start_error("edgesink host=0.0.0.0 port=0 allow=a/b/c"), "allow");
}

TEST(EdgeTcp, ConnectsOnlyToAnEdgesinkThatAllowNames) {
  const auto out = make_harness("edgesink port=0");
  const std::string source = "edgesrc dest-port=" + std::to_string(get_port(out));
  EXPECT_SAYS(start_error(source + " allow=10.0.0.0/8"), "fix: allow=10.0.0.0/8,localhost");
  EXPECT_EQ(start_error(source + " allow=127.0.0.0/8"), "");
}

TEST(EdgeTcp, AnEdgesinkThatIsNotThereIsNamed) {
  const auto out = make_harness("edgesink port=0");
  const guint port = get_port(out);
  gst_element_set_state(find_element(out, "edgesink").get(), GST_STATE_NULL);
  const std::string error = start_error("edgesrc dest-port=" + std::to_string(port));
  EXPECT_SAYS(error, "localhost:" + std::to_string(port));
  EXPECT_SAYS(error, "reconnect=true");
}

}  // namespace edge_tcp_test
