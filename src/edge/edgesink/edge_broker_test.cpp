// edgesink and edgesrc with a broker: connect-type=HYBRID and MQTT.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/wire/mqtt_frame.hpp"
#include "elements/tests/element_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "transport/mqtt/broker_client.hpp"
#include "transport/mqtt/broker_test_support.hpp"

namespace edge_broker_test {

using namespace std::chrono_literals;
using namespace weir::test;
using weir::transport::BrokerClient;

constexpr char kCaps[] = "other/tensor,dimension=(string)4,type=(string)uint8,framerate=30/1";

class EdgeBroker : public BrokerTest {
 protected:
  void SetUp() override {
    BrokerTest::SetUp();
    if (!IsSkipped()) broker_ = std::make_unique<TestBroker>();
  }
  std::string at_broker(const std::string& type) const {
    return " connect-type=" + type + " dest-host=127.0.0.1 dest-port=" + broker_->port_text() +
           " topic=objects ";
  }
  Harness sink(const std::string& type, const std::string& more = "",
               const std::string& caps = kCaps) const {
    return make_harness("edgesink sync=false port=0" + at_broker(type) + more, caps);
  }
  Harness source(const std::string& type, const std::string& more = "") const {
    Harness out{gst_harness_new_parse(("edgesrc" + at_broker(type) + more).c_str())};
    gst_harness_play(out.get());
    return out;
  }
  std::unique_ptr<BrokerClient> client() const {
    weir::transport::BrokerOptions options;
    options.port = broker_->port();
    auto out = BrokerClient::open(options);
    EXPECT_TRUE(out);
    return *std::move(out);
  }
  static bool has_receivers(const Harness& sink, guint number) {
    return becomes_true(
        [&] {
          guint count = 0;
          gst_structure_get_uint(stats(find_element(sink, "edgesink").get()).get(), "receivers",
                                 &count);
          return count == number;
        },
        "the receivers");
  }
  static bool has_receiver(const Harness& sink) { return has_receivers(sink, 1); }
  // The first byte of the next buffer.
  static int pull(const Harness& h) {
    const auto buffer = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    guint8 out = 0;
    if (!buffer || gst_buffer_extract(buffer.get(), 0, &out, 1) != 1) return -1;
    return out;
  }
  static std::string filter(const std::string& caps) {
    return "! capsfilter caps=\"" + caps + "\"";
  }

  std::unique_ptr<TestBroker> broker_;
};

TEST_F(EdgeBroker, HybridFindsTheSink) {
  const auto out = sink("HYBRID");
  const auto in = source("HYBRID", filter(kCaps));
  ASSERT_TRUE(has_receiver(out));
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{7, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 7);
}

TEST_F(EdgeBroker, HybridWaitsForASinkThatComesLater) {
  const auto in = source("HYBRID", filter(kCaps));
  const auto out = sink("HYBRID");
  ASSERT_TRUE(has_receiver(out));
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{8, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 8);
}

// A receiver gets the caps when it connects.
TEST_F(EdgeBroker, HybridAnnouncesTheSinkWithItsFirstCaps) {
  const Harness out{
      gst_harness_new_parse(("edgesink sync=false port=0" + at_broker("HYBRID")).c_str())};
  gst_harness_play(out.get());
  const auto in = source("HYBRID");
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("edge/#", 1));
  ASSERT_TRUE(
      peer->publish({.topic = "edge/marker", .payload = {}, .qos = 1, .properties = {}}, 30s));
  EXPECT_EQ(peer->receive(30s)->topic, "edge/marker");
  gst_harness_set_src_caps_str(out.get(), kCaps);
  EXPECT_SAYS(peer->receive(30s)->topic, "edge/inference/device-");
  ASSERT_TRUE(has_receiver(out));
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{7, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 7);
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(in->sinkpad));
  const auto sent = Ref<GstCaps>::adopt(gst_caps_from_string(kCaps));
  EXPECT_TRUE(gst_caps_is_equal(caps.get(), sent.get()));
}

TEST_F(EdgeBroker, HybridAnnouncesASinkWithoutCapsWithItsFirstBuffer) {
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("edge/#", 1));
  PlayedPipeline sending(
      "fakesrc num-buffers=1 sizetype=fixed sizemax=4 ! edgesink sync=false port=0" +
      at_broker("HYBRID"));
  gst_element_set_state(sending.get(), GST_STATE_PLAYING);
  EXPECT_SAYS(peer->receive(30s)->topic, "edge/inference/device-");
}

TEST_F(EdgeBroker, HybridDoesNotHangAtTheAddressOfADeadSink) {
  const auto peer = client();
  const weir::wire::HostAddress dead{"127.0.0.1", free_port()};
  ASSERT_TRUE(peer->publish({.topic = "edge/inference/device-1/objects/",
                             .payload = weir::wire::announcement_payload(dead),
                             .qos = 1,
                             .retain = true,
                             .properties = {}},
                            30s));
  ASSERT_TRUE(peer->flush(30s));
  const auto out = sink("HYBRID");
  const auto in = source("HYBRID", filter(kCaps));
  ASSERT_TRUE(has_receiver(out));
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{9, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 9);
  EXPECT_EQ(stat(in, "edgesrc", "refused"), 1u);
}

TEST_F(EdgeBroker, HybridGoesOnWithAnotherSink) {
  auto first = sink("HYBRID");
  const auto in = source("HYBRID", filter(kCaps));
  ASSERT_TRUE(has_receiver(first));
  const auto second = sink("HYBRID");
  ASSERT_EQ(gst_harness_push(first.get(), frame(Bytes{1, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 1);
  first.reset();
  ASSERT_TRUE(has_receiver(second));
  ASSERT_EQ(gst_harness_push(second.get(), frame(Bytes{2, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 2);
  EXPECT_EQ(stat(in, "edgesrc", "reconnections"), 1u);
}

TEST_F(EdgeBroker, HybridHasCapsAfterASecondStart) {
  const auto out = sink("HYBRID");
  const auto in = source("HYBRID");
  for (uint8_t i = 1; i <= 2; ++i) {
    ASSERT_TRUE(has_receiver(out));
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{i, 0, 0, 0})), GST_FLOW_OK);
    EXPECT_EQ(pull(in), i);
    const auto pad =
        Ref<GstPad>::adopt(gst_element_get_static_pad(find_element(in, "edgesrc").get(), "src"));
    EXPECT_TRUE(Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad.get())));
    gst_element_set_state(in->element, GST_STATE_NULL);
    EXPECT_TRUE(has_receivers(out, 0));
    gst_harness_play(in.get());
  }
}

TEST_F(EdgeBroker, HybridStopsWhileItWaits) {
  const auto in = source("HYBRID", filter(kCaps));
  gst_element_set_state(find_element(in, "edgesrc").get(), GST_STATE_NULL);
  EXPECT_EQ(gst_harness_buffers_received(in.get()), 0u);
}

TEST_F(EdgeBroker, MqttCarriesFramesThroughTheBroker) {
  const auto in = source("MQTT", filter(kCaps));
  const auto out = sink("MQTT");
  for (uint8_t i = 0; i < 20; ++i)
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{i, 0, 0, 0})), GST_FLOW_OK);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(pull(in), i);
}

// docs/compatibility/edge-wire.md 10.7: the header, then the memory; 10.5: retained, QoS 1.
TEST_F(EdgeBroker, MqttPublishesTheBytesOfThePage) {
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("edge/#", 2));
  const auto out = sink("MQTT");
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4})), GST_FLOW_OK);
  const auto message = peer->receive(30s);
  ASSERT_TRUE(message);
  Bytes expected(2080);
  const Bytes head{0xda, 0xed, 0xda, 0xed, 0, 0, 0, 0, 2, 0, 0, 6, 0,
                   0,    0xdd, 0xef, 1,    0, 0, 0, 0, 0, 0, 0, 4};
  std::ranges::copy(head, expected.begin());
  for (const uint8_t byte : {1, 2, 3, 4}) expected.push_back(byte);
  ASSERT_EQ(message->payload.size(), expected.size());
  EXPECT_EQ(std::memcmp(message->payload.data(), expected.data(), expected.size()), 0);
  const auto late = client();
  ASSERT_TRUE(late->subscribe("edge/inference/+/objects/#", 1));
  EXPECT_TRUE(late->receive(30s)->retained);
}

TEST_F(EdgeBroker, MqttRemovesTheLastFrameAtTheEnd) {
  auto out = sink("MQTT");
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 2, 3, 4})), GST_FLOW_OK);
  out.reset();
  const auto late = client();
  ASSERT_TRUE(late->subscribe("edge/#", 1));
  ASSERT_TRUE(late->publish({.topic = "edge/x", .qos = 1}, 30s));
  EXPECT_EQ(late->receive(30s)->topic, "edge/x");
}

TEST_F(EdgeBroker, MqttGoesOnWithoutMessagesThatAreNoFrames) {
  const auto in = source("MQTT", filter(kCaps));
  const auto peer = client();
  const std::string_view text("127.0.0.1:4100\0", 15);
  for (const auto payload : {text, text.substr(0, 1), text.substr(0, 0)})
    ASSERT_TRUE(peer->publish({.topic = "edge/inference/device-1/objects/",
                               .payload = std::as_bytes(std::span(payload)),
                               .qos = 1,
                               .properties = {}},
                              30s));
  const auto out = sink("MQTT");
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{5, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 5);
  EXPECT_EQ(stat(in, "edgesrc", "refused"), 2u);
}

TEST_F(EdgeBroker, TheFormsOfOlderVersionsAreUnderstood) {
  for (const char* version : {"0.2.6", "0.2.4", "0.2.2"}) {
    const auto in = source("MQTT", filter(kCaps));
    const auto out = sink("MQTT", std::string("wire-version=") + version);
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{6, 0, 0, 0})), GST_FLOW_OK);
    EXPECT_EQ(pull(in), 6) << version;
  }
}

TEST_F(EdgeBroker, HybridStreamsWithoutTheBrokerAndAnnouncesAgain) {
  const auto out = sink("HYBRID");
  const auto in = source("HYBRID", filter(kCaps));
  ASSERT_TRUE(has_receiver(out));
  broker_->stop();
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 1);
  broker_->start();  // it has forgotten what it retained
  const auto late = source("HYBRID", filter(kCaps));
  const auto two = [&] {
    guint count = 0;
    gst_structure_get_uint(stats(find_element(out, "edgesink").get()).get(), "receivers", &count);
    return count == 2;
  };
  ASSERT_TRUE(becomes_true(two, "two receivers"));
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{2, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(late), 2);
}

TEST_F(EdgeBroker, HybridGoesOnAfterASinkThatStartsAgain) {
  auto out = sink("HYBRID");
  const auto in = source("HYBRID", filter(kCaps));
  for (uint8_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(has_receiver(out));
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{i, 0, 0, 0})), GST_FLOW_OK);
    EXPECT_EQ(pull(in), i);
    out.reset();
    out = sink("HYBRID");
  }
  // The sink counts a receiver before the source has seen the response.
  EXPECT_TRUE(becomes_true([&] { return stat(in, "edgesrc", "reconnections") == 5u; },
                           "the fifth reconnection"));
}

TEST_F(EdgeBroker, MqttResumesWithinTwoSecondsOfABrokerRestart) {
  const auto in = source("MQTT", filter(kCaps));
  const auto out = sink("MQTT");
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{1, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 1);
  uint8_t restarts = 0;
  const auto connected = [&](const Harness& h, const char* element) {
    return becomes_true([&] { return stat(h, element, "connections") == restarts + 1u; }, element);
  };
  const auto resume = [&] {
    ASSERT_TRUE(connected(in, "edgesrc"));
    ASSERT_TRUE(connected(out, "edgesink"));
    const uint8_t number = restarts + 1;
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{number, 0, 0, 0})), GST_FLOW_OK);
    EXPECT_EQ(pull(in), number);
  };
  const auto restart = [&] {
    broker_->stop();
    broker_->start();
    ++restarts;
  };
  EXPECT_TRUE(is_quick(restart, resume, 2s));
}

TEST_F(EdgeBroker, MqttDropsFramesWhileTheBrokerIsFrozen) {
  const auto in = source("MQTT", filter(kCaps));
  const auto out = sink("MQTT");
  Errors errors(out);
  broker_->signal(SIGSTOP);
  uint8_t sent = 0;
  while (stat(out, "edgesink", "dropped-policy") == 0)
    ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{++sent, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_SAYS(errors.next_warning(), "it accepted no message within 1000 ms");
  broker_->signal(SIGCONT);
  // What was in progress arrives, then the stream goes on.
  for (uint8_t i = 1; i < sent; ++i) EXPECT_EQ(pull(in), i);
  ASSERT_EQ(gst_harness_push(out.get(), frame(Bytes{200, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(pull(in), 200);
}

TEST_F(EdgeBroker, BrokersThatAreNotThereAreNamed) {
  broker_->stop();
  for (const std::string element : {"edgesink", "edgesrc"})
    for (const char* type : {"HYBRID", "MQTT"}) {
      const std::string error = start_error(element + " port=0" + at_broker(type));
      EXPECT_SAYS(error, "the MQTT broker 127.0.0.1:" + broker_->port_text());
      EXPECT_SAYS(error, "or set dest-host and dest-port");
    }
}

TEST_F(EdgeBroker, TopicsThatCannotBeUsedAreNamed) {
  for (const std::string element : {"edgesink", "edgesrc"})
    for (const char* type : {"HYBRID", "MQTT"}) {
      const std::string start = element + " port=0" + at_broker(type);
      EXPECT_SAYS(start_error(start + "topic=\"\""), "topic cannot be part of an MQTT topic");
      EXPECT_SAYS(start_error(start + "topic=\"\""), "fix: topic=objects");
      EXPECT_SAYS(start_error(start + "topic=a/+"), "a/+");
      EXPECT_SAYS(start_error(start + "dest-port=0"), "dest-port=1883");
    }
}

}  // namespace edge_broker_test
