// BrokerClient with a mosquitto: delivery, reconnection, refusals, and that it stops in every
// state.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/broker_client.hpp"

#include <cstring>
#include <thread>

#include "says.hpp"
#include "transport/mqtt/broker_test_support.hpp"

namespace weir::transport {
namespace broker_client_test {

using namespace std::chrono_literals;
using test::TestBroker;
using Client = std::unique_ptr<BrokerClient>;

class BrokerClientTest : public test::BrokerTest {};

std::vector<std::byte> bytes(std::string_view text) {
  const auto span = std::as_bytes(std::span(text.data(), text.size()));
  return {span.begin(), span.end()};
}
std::string text(const MqttMessage& message) {
  return {reinterpret_cast<const char*>(message.payload.data()), message.payload.size()};
}
BrokerOptions options(uint16_t port, MqttVersion version = MqttVersion::V311) {
  BrokerOptions out;
  out.port = port;
  out.version = version;
  return out;
}
Client open(const BrokerOptions& options) {
  auto client = BrokerClient::open(options);
  EXPECT_TRUE(client) << client.error().message();
  return client ? *std::move(client) : nullptr;
}
Status publish(BrokerClient& client, const std::string& topic, const std::string& payload,
               int qos = 1, bool retain = false, MqttProperties properties = {}) {
  const auto held = bytes(payload);
  return client.publish({.topic = topic,
                         .payload = held,
                         .qos = qos,
                         .retain = retain,
                         .properties = std::move(properties)},
                        30s);
}
// A listener that answers nothing.
class SilentPeer {
 public:
  SilentPeer() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    listen(fd_, 4);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &length);
    port_ = ntohs(address.sin_port);
  }
  ~SilentPeer() { close(fd_); }
  uint16_t port() const { return port_; }

 private:
  const int fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  uint16_t port_ = 0;
};

TEST_F(BrokerClientTest, DeliversMessagesInOrder) {
  const TestBroker broker;
  for (const auto version : {MqttVersion::V311, MqttVersion::V5})
    for (const int qos : {0, 1, 2}) {
      BrokerOptions many = options(broker.port(), version);
      many.max_received_messages = 1000;
      const Client receiver = open(many);
      ASSERT_TRUE(receiver->subscribe("a/+", qos));
      const Client sender = open(options(broker.port(), version));
      std::jthread sending([&] {
        for (int i = 0; i < 200; ++i)
          EXPECT_TRUE(publish(*sender, "a/b", "message " + std::to_string(i), qos));
      });
      for (int i = 0; i < 200; ++i) {
        const auto message = receiver->receive(30s);
        ASSERT_TRUE(message) << qos << " " << i;
        EXPECT_EQ(text(*message), "message " + std::to_string(i));
        EXPECT_EQ(message->topic, "a/b");
        EXPECT_FALSE(message->retained);
      }
      sending.join();
      EXPECT_TRUE(sender->flush(30s));
      EXPECT_EQ(sender->counts().published, 200u);
      EXPECT_EQ(receiver->counts().dropped, 0u);
    }
}

TEST_F(BrokerClientTest, CarriesThePropertiesOfMqtt5) {
  const TestBroker broker;
  const Client client = open(options(broker.port(), MqttVersion::V5));
  ASSERT_TRUE(client->subscribe("t", 1));
  const MqttProperties sent{.content_type = "application/x",
                            .response_topic = "answers",
                            .correlation_data = bytes(std::string("a\0b", 3)),
                            .expiry = 60,
                            .user = {{"caps", "x"}, {"seq", "1"}, {"caps", "y"}}};
  ASSERT_TRUE(publish(*client, "t", "", 1, false, sent));
  const auto message = client->receive(30s);
  ASSERT_TRUE(message);
  const MqttProperties& got = message->properties;
  EXPECT_TRUE(message->payload.empty());
  EXPECT_EQ(got.content_type, sent.content_type);
  EXPECT_EQ(got.response_topic, sent.response_topic);
  EXPECT_EQ(got.correlation_data, sent.correlation_data);
  EXPECT_EQ(got.user, sent.user);
  ASSERT_TRUE(got.expiry);
  EXPECT_LE(*got.expiry, 60u);
  EXPECT_EQ(got.find("caps"), "x");
  EXPECT_EQ(got.find("pts"), std::nullopt);
}

TEST_F(BrokerClientTest, ConnectsAgainAndSubscribesAgain) {
  TestBroker broker;
  const Client receiver = open(options(broker.port()));
  ASSERT_TRUE(receiver->subscribe("t", 1));
  const Client sender = open(options(broker.port()));
  ASSERT_TRUE(publish(*sender, "t", "before"));
  EXPECT_TRUE(receiver->receive(30s));
  broker.stop();
  EXPECT_TRUE(becomes_true([&] { return !sender->is_connected() && !receiver->is_connected(); },
                           "a lost connection"));
  const auto status = sender->publish({.topic = "t"}, 1ms);
  EXPECT_REFUSED(status, BROKER_UNREACHABLE, "offered: no connection within 1 ms");
  broker.start();
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(becomes_true([&] { return receiver->is_connected(); }, "a connection"));
  ASSERT_TRUE(publish(*sender, "t", "after"));
  const auto message = receiver->receive(30s);
  ASSERT_TRUE(message);
  EXPECT_EQ(text(*message), "after");
  EXPECT_LT(std::chrono::steady_clock::now() - began, 2s);
  EXPECT_EQ(receiver->counts().connections, 2u);
}

TEST_F(BrokerClientTest, AWillIsPublishedOnlyWithoutAGoodbye) {
  const TestBroker broker;
  const Client watching = open(options(broker.port()));
  ASSERT_TRUE(watching->subscribe("gone", 1));
  BrokerOptions with_will = options(broker.port());
  with_will.will = MqttWill{.topic = "gone", .payload = bytes("will"), .retain = false};
  open(with_will).reset();
  ASSERT_TRUE(publish(*watching, "gone", "not by the will"));
  EXPECT_EQ(text(*watching->receive(30s)), "not by the will");

  // The broker ends the connection of a client whose identifier comes again.
  with_will.client_id = "twice";
  const Client first = open(with_will);
  const Client second = open(with_will);
  EXPECT_EQ(text(*watching->receive(30s)), "will");
}

TEST_F(BrokerClientTest, RejectsWhatCannotBeReached) {
  const uint16_t port = test::free_port();
  EXPECT_REFUSED(BrokerClient::open(options(port)), BROKER_UNREACHABLE,
                 "offered: Connection refused");
  EXPECT_SAYS(BrokerClient::open(options(port)).error().message(), "mosquitto -p ");
  BrokerOptions unknown = options(port);
  unknown.host = "no-such-host.invalid";
  EXPECT_REFUSED(BrokerClient::open(unknown), BROKER_UNREACHABLE, "no-such-host.invalid");
  const SilentPeer silent;
  BrokerOptions patient = options(silent.port());
  patient.connect_timeout = 100ms;
  EXPECT_REFUSED(BrokerClient::open(patient), BROKER_UNREACHABLE, "no answer within 100 ms");
}

TEST_F(BrokerClientTest, RejectsFilesThatAreNotThere) {
  BrokerOptions tls = options(1);
  tls.tls.ca = "/no/such/file.pem";
  EXPECT_REFUSED(BrokerClient::open(tls), FILE_NOT_FOUND, "the file of the property tls-ca");
  tls.tls = {.cert = "/etc/hostname"};
  EXPECT_REFUSED(BrokerClient::open(tls), OPTION_VALUE, "tls-cert and tls-key");
  tls.tls = {.psk = "abcd"};
  EXPECT_REFUSED(BrokerClient::open(tls), OPTION_VALUE, "psk-identity");
  tls.tls = {.psk = "not hexadecimal", .psk_identity = "me"};
  EXPECT_REFUSED(BrokerClient::open(tls), OPTION_VALUE, "hexadecimal digits");
}

TEST_F(BrokerClientTest, ReportsARefusal) {
  const TestBroker broker("allow_anonymous false\n");
  for (const auto version : {MqttVersion::V311, MqttVersion::V5}) {
    const auto client = BrokerClient::open(options(broker.port(), version));
    EXPECT_REFUSED(client, BROKER_REFUSED, "does not accept the client");
    EXPECT_SAYS(client.error().message(), "fix: set user and password");
  }
}

TEST_F(BrokerClientTest, RejectsTopicsAndLargeMessages) {
  const TestBroker broker("allow_anonymous true\nmessage_size_limit 1000\n");
  const Client client = open(options(broker.port(), MqttVersion::V5));
  EXPECT_REFUSED(publish(*client, "a/#", ""), OPTION_VALUE, "without the wildcards");
  EXPECT_REFUSED(publish(*client, std::string("a\0b", 3), ""), OPTION_VALUE, "without NUL");
  EXPECT_REFUSED(client->subscribe("a/#/b", 0), OPTION_VALUE, "# as the last one");
  EXPECT_REFUSED(client->publish({.topic = "t", .properties = {.response_topic = "a/#"}}, 1s),
                 OPTION_VALUE, "the property response-topic is not an MQTT topic");
  ASSERT_TRUE(publish(*client, "t", std::string(1001, 'x')));
  EXPECT_TRUE(client->flush(30s));
  EXPECT_EQ(client->counts().refused, 1u);
  EXPECT_EQ(client->counts().published, 0u);
}

TEST_F(BrokerClientTest, KeepsTheNewestOfAFlood) {
  const TestBroker broker;
  BrokerOptions few = options(broker.port());
  few.max_received_messages = 5;
  const Client receiver = open(few);
  ASSERT_TRUE(receiver->subscribe("t", 0));
  const Client sender = open(options(broker.port()));
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(publish(*sender, "t", std::to_string(i), 0));
  EXPECT_TRUE(becomes_true([&] { return receiver->counts().dropped == 95; }, "95 dropped"));
  EXPECT_EQ(text(*receiver->receive(30s)), "95");
}

TEST_F(BrokerClientTest, LeavesMessagesOfQos1ToTheBroker) {
  const TestBroker broker;
  BrokerOptions few = options(broker.port(), MqttVersion::V5);
  few.max_received_messages = 8;
  few.receive_maximum = 2;
  const Client receiver = open(few);
  ASSERT_TRUE(receiver->subscribe("t", 1));
  const Client sender = open(options(broker.port()));
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(publish(*sender, "t", std::to_string(i)));
  for (int i = 0; i < 300; ++i) EXPECT_EQ(text(*receiver->receive(30s)), std::to_string(i));
  EXPECT_EQ(receiver->counts().dropped, 0u);
}

TEST_F(BrokerClientTest, EndsWaitsWhenInterrupted) {
  TestBroker broker;
  const Client client = open(options(broker.port()));
  std::jthread receiving([&] { EXPECT_FALSE(client->receive(1h)); });
  client->interrupt(true);
  receiving.join();
  EXPECT_REFUSED(publish(*client, "t", ""), CANCELLED, "interrupted");
  client->interrupt(false);
  EXPECT_TRUE(publish(*client, "t", ""));
  broker.stop();
  std::jthread publishing([&] {
    while (publish(*client, "t", "", 0)) {
    }
  });
  EXPECT_TRUE(becomes_true([&] { return !client->is_connected(); }, "a lost connection"));
  client->interrupt(true);
  publishing.join();
}

TEST_F(BrokerClientTest, StopsInEveryState) {
  TestBroker broker;
  for (int i = 0; i < 10; ++i) {
    const Client client = open(options(broker.port()));
    if (i % 2) {
      EXPECT_TRUE(client->subscribe("#", 2));
    }
    EXPECT_TRUE(publish(*client, "t", std::string(1 << 20, 'x'), i % 3));
  }
  const Client waiting = open(options(broker.port()));
  broker.stop();
  EXPECT_TRUE(becomes_true([&] { return !waiting->is_connected(); }, "a lost connection"));
}

TEST_F(BrokerClientTest, CountsMessagesOfAKilledBrokerAsLost) {
  TestBroker broker;
  const Client client = open(options(broker.port()));
  broker.stop();
  uint64_t accepted = 0;
  while (client->publish({.topic = "t", .payload = bytes(std::string(1 << 20, 'x'))}, 0ms))
    ++accepted;
  EXPECT_TRUE(becomes_true([&] { return !client->is_connected(); }, "a lost connection"));
  const auto counts = client->counts();
  EXPECT_EQ(counts.published + counts.lost, accepted);
}

}  // namespace broker_client_test
}  // namespace weir::transport
