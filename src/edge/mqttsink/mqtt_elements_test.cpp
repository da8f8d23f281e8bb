// mqttsink and mqttsrc with a mosquitto and with a plain client: bytes, properties, times,
// responses, messages that are none, and a broker that restarts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "edge/mqtt_elements_test_support.hpp"
#include "elements/tests/flushed_start_test_support.hpp"

namespace weir::test {
namespace mqtt_elements_test {

TEST_F(MqttElements, WritesTheHeaderOfThePage) {
  const auto peer = client(MqttVersion::V311);
  ASSERT_TRUE(peer->subscribe("t", 1));
  const int64_t before = transport::unix_time();
  PlayedPipeline p(frames(3) + sink("pub-topic=t mqtt-qos=1 num-buffers=3"));
  EXPECT_EQ(p.plays_to_its_end(), "");
  const auto message = peer->receive(30s);
  ASSERT_TRUE(message);
  const Bytes8& b = message->payload;
  ASSERT_EQ(b.size(), 1028u);
  EXPECT_EQ(at<uint32_t>(b, 0), 1u);
  EXPECT_EQ(at<uint64_t>(b, 8), 4u);
  for (size_t i = 1; i < 16; ++i) EXPECT_EQ(at<uint64_t>(b, 8 + 8 * i), 0u);
  EXPECT_GE(at<int64_t>(b, 136), before);
  EXPECT_GE(at<int64_t>(b, 144), at<int64_t>(b, 136));
  EXPECT_LE(at<int64_t>(b, 144), transport::unix_time());
  EXPECT_EQ(at<uint64_t>(b, 152), 10'000'000u);
  EXPECT_EQ(at<uint64_t>(b, 160), UINT64_MAX);
  EXPECT_LT(at<uint64_t>(b, 168), uint64_t{60'000'000'000});
  const std::string caps(reinterpret_cast<const char*>(b.data() + 176));
  EXPECT_SAYS(caps, "other/tensor, dimension=(string)1:4:1:1, type=(string)uint8");
  for (size_t i = 176 + caps.size(); i < 1024; ++i) EXPECT_EQ(b[i], std::byte{0});
  EXPECT_EQ(at<uint32_t>(b, 1024), 0xEBEBEBEBu) << "white in video range";
  EXPECT_EQ(p.stat("sink", "received"), 3u);
  EXPECT_EQ(p.stat("sink", "consumed"), 3u);

  const auto late = client();
  ASSERT_TRUE(late->subscribe("t", 1));
  EXPECT_TRUE(late->receive(30s)->retained);
}

TEST_F(MqttElements, ReadsTheMessageOfThePage) {
  PlayedPipeline p(source("sub-topic=t num-buffers=1") + " ! tensor_sink name=out async=false");
  p.watch("out");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client();
  const int64_t soon = transport::unix_time() + 1'000'000'000;
  publish(*peer, message_of_page(kMqttCaps, soon, 1, 0));  // sent before the pipeline began
  publish(*peer, message_of_page(kMqttCaps, 0, soon, 0));  // its PTS would be negative
  publish(*peer, message_of_page(kMqttCaps, soon, soon, 5'000'000'000));
  EXPECT_EQ(p.outcome(), "");
  EXPECT_EQ(p.seen<uint8_t>("out"), (std::vector<std::vector<uint8_t>>{{1, 2, 3, 4}}));
  EXPECT_EQ(p.stat("source", "received"), 3u);
  EXPECT_EQ(p.stat("source", "dropped-time"), 2u);
}

TEST_F(MqttElements, KeepsStoredMessagesOnRequest) {
  PlayedPipeline p(source("sub-topic=t num-buffers=2 keep-stored=true") +
                   " ! tensor_sink name=out async=false");
  p.watch("out");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client();
  const int64_t soon = transport::unix_time() + 1'000'000'000;
  publish(*peer, message_of_page(kMqttCaps, 1, 2, 0));  // sent long before the pipeline began
  publish(*peer, message_of_page(kMqttCaps, soon, soon, 5'000'000'000));
  EXPECT_EQ(p.outcome(), "");
  EXPECT_EQ(p.seen<uint8_t>("out").size(), 2u);
  EXPECT_EQ(p.stat("source", "dropped-time"), 0u);
}

// Programs of NNStreamer write each property in any state.
TEST_F(MqttElements, TakesPropertiesWhileItPlaysForTheNextStart) {
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("t", 1));
  PlayedPipeline p(frames(-1) + sink("pub-topic=t mqtt-qos=1 protocol=5"));
  const auto element = p.find("sink");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  ASSERT_TRUE(peer->receive(30s));
  g_object_set(element.get(), "host", "other", "client-id", "me", "pub-topic", "u", "mqtt-qos", 2,
               nullptr);
  gchar *host = nullptr, *topic = nullptr;
  g_object_get(element.get(), "host", &host, "pub-topic", &topic, nullptr);
  EXPECT_STREQ(gst::UniqueText(host).get(), "other");
  EXPECT_STREQ(gst::UniqueText(topic).get(), "u");
  ASSERT_TRUE(peer->receive(30s)) << "the connection is as before";
  g_object_set(element.get(), "num-buffers", 1, nullptr);  // fewer than were sent
  EXPECT_EQ(p.outcome(), "");
}

TEST_F(MqttElements, TakesHostsWithAScheme) {
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("t", 1));
  for (const char* host : {"tcp://127.0.0.1", "mqtt://127.0.0.1"}) {
    PlayedPipeline p(frames(1) + sink(std::string("pub-topic=t mqtt-qos=1 host=") + host));
    EXPECT_EQ(p.plays_to_its_end(), "") << host;
    EXPECT_TRUE(peer->receive(30s)) << host;
  }
}

TEST_F(MqttElements, SendsCapsAndTimesAsPropertiesOfMqtt5) {
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("t", 1));
  PlayedPipeline p(frames(2) + sink("pub-topic=t mqtt-qos=1 protocol=5 max-age=1500"));
  EXPECT_EQ(p.plays_to_its_end(), "");
  for (const char* number : {"0", "1"}) {
    const auto message = peer->receive(30s);
    ASSERT_TRUE(message);
    const MqttProperties& got = message->properties;
    EXPECT_EQ(message->payload, Bytes8(4, std::byte{235}));
    EXPECT_FALSE(message->retained);
    EXPECT_EQ(got.content_type, "other/tensor");
    EXPECT_EQ(got.expiry, 2u);
    EXPECT_EQ(got.find("seq"), number);
    EXPECT_EQ(got.find("dur"), "10000000");
    for (const char* name : {"caps", "pts", "base-epoch", "sent-epoch"})
      EXPECT_TRUE(got.find(name)) << name;
    EXPECT_TRUE(got.response_topic.empty());
  }
  p.reaches(GST_STATE_NULL);
  EXPECT_FALSE(peer->receive(0ms)) << "no will after a goodbye";
}

TEST_F(MqttElements, CountsGapsAndIgnoresHostileMessages) {
  PlayedPipeline p(source("protocol=5 sub-topic=t num-buffers=4") +
                   " ! tensor_sink name=out async=false");
  p.watch("out");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client();
  publish(*peer, bytes("x"));
  publish(*peer, {});
  publish(*peer, bytes("gone"));
  MqttProperties sizes = frame(3);
  sizes.user.emplace_back("sizes", "18446744073709551615,5");
  publish(*peer, bytes("abcd"), sizes);
  const auto future = std::to_string(transport::unix_time() + 60'000'000'000);
  for (const uint64_t seq : {3, 4, 7, 8}) {
    MqttProperties good = frame(seq);
    good.user[2].second = future;
    good.user.emplace_back("sent-epoch", future);
    publish(*peer, bytes("abcd"), good);
  }
  EXPECT_EQ(p.outcome(), "");
  EXPECT_EQ(p.seen<uint8_t>("out").size(), 4u);
  EXPECT_EQ(p.stat("source", "messages-lost"), 2u);
  EXPECT_EQ(p.stat("source", "messages-invalid"), 3u);
  EXPECT_EQ(p.stat("source", "senders-gone"), 1u);
}

TEST_F(MqttElements, IgnoresPayloadsThatAreNoMessages) {
  PlayedPipeline p(source("sub-topic=t num-buffers=1") + " ! tensor_sink name=out async=false");
  p.watch("out");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client(MqttVersion::V311);
  const int64_t soon = transport::unix_time() + 1'000'000'000;
  auto good = message_of_page(kMqttCaps, soon, soon, 0);
  auto count = good, size = good;
  count[0] = std::byte{17};
  size[15] = std::byte{255};
  for (const auto& payload : {bytes("x"), Bytes8{}, Bytes8(1023), count, size})
    publish(*peer, payload);
  publish(*peer, good);
  EXPECT_EQ(p.outcome(), "");
  EXPECT_EQ(p.stat("source", "messages-invalid"), 5u);
  EXPECT_EQ(p.seen<uint8_t>("out").size(), 1u);
}

TEST_F(MqttElements, AnswersRequests) {
  PlayedPipeline p(source("protocol=5 sub-topic=ask") +
                   " ! tensor_transform mode=arithmetic option=add:1 ! " +
                   sink("protocol=5 pub-topic=unused mqtt-qos=1 async=false"));
  // Newer brokers do not forward a request with such a topic.
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(p.find("source").get(), "src"));
  gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer) {
        auto* request = gst_buffer_get_custom_meta(GST_PAD_PROBE_INFO_BUFFER(info), "WeirMqttMeta");
        gst_structure_set(gst_custom_meta_get_structure(request), "response-topic", G_TYPE_STRING,
                          "not/+/valid", nullptr);
        return GST_PAD_PROBE_REMOVE;
      },
      nullptr, nullptr);
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("answers", 1));
  const std::string caps = kMqttCaps;
  for (int i = 0; i < 2; ++i) {
    MqttProperties question{.response_topic = "answers",
                            .correlation_data = bytes("number 7"),
                            .user = {{"caps", caps}, {"traceparent", "00-ab-cd-01"}}};
    const auto payload = bytes("abcd");
    const auto sent =
        peer->publish({.topic = "ask", .payload = payload, .qos = 1, .properties = question}, 30s);
    EXPECT_TRUE(sent);
  }
  const auto response = peer->receive(30s);
  ASSERT_TRUE(response);
  EXPECT_EQ(response->payload, bytes("bcde"));
  EXPECT_EQ(response->properties.correlation_data, bytes("number 7"));
  EXPECT_EQ(response->properties.find("traceparent"), "00-ab-cd-01");
  EXPECT_EQ(response->properties.find("seq"), "1") << "the invalid one counts";
  EXPECT_TRUE(becomes_true([&] { return p.stat("sink", "consumed") == 1; }, "the answer"));
  EXPECT_EQ(p.stat("sink", "answers-invalid"), 1u);
  EXPECT_EQ(p.stat("sink", "dropped-error"), 1u);
}

TEST_F(MqttElements, RejectsAnInvalidResponseTopic) {
  EXPECT_SAYS(error_of_pipeline(frames(1) + sink("protocol=5 response-topic=a/#")),
              "the property response-topic is not an MQTT topic");
}

TEST_F(MqttElements, WaitsWithoutALimitForTheLongestTimeout) {
  PlayedPipeline p(source("sub-topic=t num-buffers=1 sub-timeout=9223372036854775807") +
                   " ! tensor_sink name=out async=false");
  ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
  const auto peer = client();
  const int64_t soon = transport::unix_time() + 60'000'000'000;
  publish(*peer, message_of_page(kMqttCaps, soon, soon, 0));
  EXPECT_EQ(p.outcome(), "");
}

TEST_F(MqttElements, ResumesAfterABrokerRestart) {
  PlayedPipeline receiving(source("sub-topic=t num-buffers=100000") +
                           " ! fakesink name=end async=false");
  ASSERT_TRUE(receiving.reaches(GST_STATE_PLAYING));
  PlayedPipeline sending(frames(-1) + sink("pub-topic=t"));
  gst_element_set_state(sending.get(), GST_STATE_PLAYING);
  const auto pushed = [&] { return receiving.stat("source", "pushed"); };
  EXPECT_TRUE(becomes_true([&] { return pushed() > 10; }, "frames"));
  uint64_t restarts = 0, lost = 0;
  const auto restart = [&] {
    broker_->stop();
    EXPECT_TRUE(
        becomes_true([&] { return sending.stat("sink", "dropped-lost") > lost; }, "lost frames"));
    broker_->start();
    ++restarts;
  };
  const auto resume = [&] {
    const uint64_t before = pushed();
    EXPECT_TRUE(becomes_true([&] { return pushed() > before + 10; }, "frames after the restart"));
    lost = sending.stat("sink", "dropped-lost");
  };
  EXPECT_TRUE(is_quick(restart, resume, 2s));
  EXPECT_EQ(receiving.stat("source", "connections"), restarts + 1);
}

// PAUSED while the stream waits for a broker that answers nothing.
TEST_F(MqttElements, PublishesTheBufferThatAPauseInterrupted) {
  constexpr uint64_t kMaxInProgress = 20, kFrames = kMaxInProgress + 5;
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("t", 1));
  PlayedPipeline p("videotestsrc num-buffers=" + std::to_string(kFrames) +
                   " ! video/x-raw,format=GRAY8,width=4,height=1,framerate=100/1 ! " +
                   sink("pub-topic=t mqtt-qos=1 pub-wait-timeout=60000"));
  ASSERT_TRUE(p.reaches(GST_STATE_READY));
  broker_->signal(SIGSTOP);
  gst_element_set_state(p.get(), GST_STATE_PLAYING);
  ASSERT_TRUE(becomes_true([&] { return p.stat("sink", "received") == kMaxInProgress + 1; },
                           "a buffer that waits"));
  ASSERT_TRUE(p.reaches(GST_STATE_PAUSED));
  broker_->signal(SIGCONT);
  EXPECT_EQ(p.plays_to_its_end(), "");
  EXPECT_EQ(p.stat("sink", "consumed"), kFrames);
  for (uint64_t i = 0; i < kFrames; ++i) ASSERT_TRUE(peer->receive(30s)) << i;
}

TEST_F(MqttElements, PublishesNumBuffersAgainAfterReady) {
  const auto peer = client();
  ASSERT_TRUE(peer->subscribe("t", 1));
  PlayedPipeline p(frames(-1) + sink("pub-topic=t mqtt-qos=1 protocol=5 num-buffers=3"));
  for (int run = 0; run < 2; ++run) {
    EXPECT_EQ(p.plays_to_its_end(), "");
    for (const char* number : {"0", "1", "2"}) {
      const auto message = peer->receive(30s);
      ASSERT_TRUE(message) << "run " << run;
      EXPECT_EQ(message->properties.find("seq"), number);
    }
    ASSERT_TRUE(p.reaches(GST_STATE_READY));
  }
}

TEST_F(MqttElements, ASourceThatStopsWhileItWaitsReportsNoError) {
  PlayedPipeline p(source("sub-topic=silent") + " ! fakesink async=false");
  Errors errors(p.get());
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(p.reaches(GST_STATE_PLAYING));
    ASSERT_TRUE(p.reaches(GST_STATE_READY));
  }
  EXPECT_EQ(errors.next(), "");
}

TEST_F(MqttElements, ASourceStartsWhileItIsFlushed) {
  start_while_flushed(source("sub-topic=silent"));
}

TEST_F(MqttElements, ReportsWhatCannotBeUsed) {
  const std::string frame = frames(1);
  EXPECT_SAYS(error_of_pipeline(source("") + " ! fakesink"),
              "the property sub-topic is not an MQTT");
  EXPECT_SAYS(error_of_pipeline(frame + sink("pub-topic=a/#")), "without the wildcards");
  EXPECT_SAYS(error_of_pipeline(frame + "mqttsink port=0"), "needed: a number from 1 to 65535");
  EXPECT_SAYS(error_of_pipeline(frame + "mqttsink port=" + std::to_string(free_port())),
              "WEIR-6005: the MQTT broker 127.0.0.1");
  EXPECT_SAYS(error_of_pipeline(frame + "mqttsink protocol=5 host=192.0.2.1"),
              "WEIR-6003: the connection to another machine is not encrypted");
  EXPECT_SAYS(error_of_pipeline(frame + sink("max-buffer-size=3")), "needed: at most 3 bytes");
  EXPECT_SAYS(error_of_pipeline("fakesrc num-buffers=1 sizetype=empty ! " + sink("")),
              "WEIR-2004: a buffer is empty");
  EXPECT_SAYS(error_of_pipeline(frame + sink("ntp-sync=true ntp-srvs=\"\"")),
              "no NTP server answers");
  EXPECT_SAYS(error_of_pipeline(source("sub-topic=silent sub-timeout=1000000") + " ! fakesink"),
              "nothing on the topic silent for 1000000 microseconds");
}

// A server that is 100 s ahead.
TEST(NtpTime, IsAskedWithOnePacket) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
  std::jthread server([fd] {
    uint8_t packet[64];
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto got =
        recvfrom(fd, packet, sizeof packet, 0, reinterpret_cast<sockaddr*>(&from), &size);
    EXPECT_EQ(got, 48);
    EXPECT_EQ(packet[0], 0x23);  // version 4, client
    std::memcpy(packet + 24, packet + 40, 8);
    packet[0] = 0x24;
    packet[1] = 1;
    const uint32_t seconds = htonl(static_cast<uint32_t>(time(nullptr) + 2208988800 + 100));
    for (const int offset : {32, 40}) {
      std::memcpy(packet + offset, &seconds, 4);
      std::memset(packet + offset + 4, 0, 4);
    }
    sendto(fd, packet, 48, 0, reinterpret_cast<sockaddr*>(&from), size);
  });
  const auto offset =
      transport::ntp_offset("127.0.0.1:" + std::to_string(ntohs(address.sin_port)), 30s);
  ASSERT_TRUE(offset);
  EXPECT_NEAR(static_cast<double>(*offset) / 1e9, 100, 1.5);
  server.join();
  close(fd);
  EXPECT_REFUSED(transport::ntp_offset("", 1s), OPTION_VALUE, "ntp-sync=false");
}

}  // namespace mqtt_elements_test
}  // namespace weir::test
