// BrokerClient and a mosquitto with TLS, pre-shared keys and passwords: what is accepted, and what
// the error of each refusal says.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "says.hpp"
#include "transport/mqtt/broker_certificates.hpp"
#include "transport/mqtt/broker_client.hpp"

namespace weir::transport {
namespace broker_tls_test {

using namespace std::chrono_literals;
using test::TestBroker;

// With both versions of MQTT, because what MQTT 5 receives is checked after it is decrypted.
class BrokerTls : public test::BrokerTest, public ::testing::WithParamInterface<MqttVersion> {
 protected:
  BrokerOptions options(const TestBroker& broker, const std::string& ca = "ca.pem") const {
    BrokerOptions out = with_version();
    out.host = "localhost";
    out.port = broker.port();
    if (!ca.empty()) out.tls.ca = files_.file(ca);
    return out;
  }
  BrokerOptions with_certificate(const TestBroker& broker, const std::string& name) const {
    BrokerOptions out = options(broker);
    out.tls.cert = files_.file(name + ".pem");
    out.tls.key = files_.file(name + ".key");
    return out;
  }
  static BrokerOptions with_version() {
    BrokerOptions out;
    out.version = GetParam();
    return out;
  }
  static BrokerOptions with_key(const TestBroker& broker, const std::string& identity,
                                const std::string& key) {
    BrokerOptions out = with_version();
    out.port = broker.port();
    out.tls.psk = key;
    out.tls.psk_identity = identity;
    return out;
  }
  static BrokerOptions with_password(const TestBroker& broker, const std::string& user,
                                     const std::string& password) {
    BrokerOptions out = with_version();
    out.port = broker.port();
    out.user = user;
    out.password = password;
    return out;
  }
  // A message makes the way to the broker and back.
  static void expect_exchange(const BrokerOptions& options) {
    const auto client = BrokerClient::open(options);
    ASSERT_TRUE(client) << client.error().message();
    ASSERT_TRUE((*client)->subscribe("t", 1));
    std::vector<std::byte> payload(100'000);
    for (size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<std::byte>(i * i >> 4);
    for (const size_t size : {size_t{0}, size_t{1}, payload.size()}) {
      const auto part = std::span(payload).first(size);
      ASSERT_TRUE(
          (*client)->publish({.topic = "t", .payload = part, .qos = 1, .properties = {}}, 30s));
      const auto received = (*client)->receive(30s);
      ASSERT_TRUE(received);
      EXPECT_TRUE(
          std::equal(part.begin(), part.end(), received->payload.begin(), received->payload.end()));
    }
  }

  const test::BrokerCertificates files_{};
};

// The client is not accepted, or does not accept the broker, for a reason, and with a remedy.
void expect_refused(const BrokerOptions& options, const std::string& reason,
                    const std::string& remedy) {
  const auto client = BrokerClient::open(options);
  ASSERT_FALSE(client);
  EXPECT_REFUSED(client, BROKER_REFUSED, reason);
  EXPECT_SAYS(client.error().message(), remedy);
}

TEST_P(BrokerTls, AcceptsABrokerOfTheAuthority) {
  const TestBroker broker(files_.settings("broker"));
  expect_exchange(options(broker));
  BrokerOptions by_address = options(broker);
  by_address.host = "127.0.0.1";
  expect_exchange(by_address);
}

TEST_P(BrokerTls, RejectsABrokerOfAnotherAuthority) {
  const TestBroker broker(files_.settings("broker"));
  expect_refused(options(broker, "other.pem"), "was not signed by the authority in",
                 "fix: set tls-ca to the file of the authority");
}

TEST_P(BrokerTls, RejectsABrokerOfAnotherName) {
  const TestBroker broker(files_.settings("elsewhere"));
  expect_refused(options(broker), "its certificate is not for localhost",
                 "weir pki issue localhost");
}

TEST_P(BrokerTls, RejectsAnExpiredBroker) {
  const TestBroker broker(files_.settings("expired"));
  expect_refused(options(broker), "its certificate has expired",
                 "fix: issue a new certificate for the broker");
}

TEST_P(BrokerTls, RejectsABrokerWithoutTls) {
  const TestBroker broker;
  const auto client = BrokerClient::open(options(broker));
  ASSERT_FALSE(client);
  EXPECT_SAYS(client.error().message(), "TLS");
  EXPECT_SAYS(client.error().message(), "8883");  // the text depends on how the broker closes
}

TEST_P(BrokerTls, WithoutTlsABrokerThatNeedsItIsNotReached) {
  const TestBroker broker(files_.settings("broker"));
  EXPECT_REFUSED(BrokerClient::open(options(broker, "")), BROKER_UNREACHABLE, "tls-ca");
}

TEST_P(BrokerTls, ABrokerThatNeedsCertificatesOfClients) {
  const TestBroker broker(files_.settings("broker", "require_certificate true\n"));
  expect_exchange(with_certificate(broker, "client"));
  expect_refused(options(broker), "it probably needs a certificate of the client",
                 "fix: set tls-cert and tls-key");
  expect_refused(with_certificate(broker, "stranger"), "it does not accept the certificate",
                 "an authority that the broker trusts");
  expect_refused(with_certificate(broker, "expired"), "expired.pem",
                 "an authority that the broker trusts");
}

TEST_P(BrokerTls, PreSharedKeys) {
  const std::string keys = files_.text_file("keys", "camera:abcdef0123456789");
  const TestBroker broker("user root\nallow_anonymous true\npsk_hint weir\npsk_file " + keys +
                          "\n");
  expect_exchange(with_key(broker, "camera", "abcdef0123456789"));
  expect_refused(with_key(broker, "camera", "abcdef0123456780"), "the pre-shared key",
                 "fix: compare psk and psk-identity");
  expect_refused(with_key(broker, "door", "abcdef0123456789"), "the pre-shared key",
                 "fix: compare psk and psk-identity");
}

// localhost is ::1 first, where this broker does not listen.
TEST_P(BrokerTls, ARefusedAddressIsLeftAtOnceForTheNext) {
  const std::string keys = files_.text_file("keys", "camera:abcdef0123456789");
  const TestBroker broker("user root\nallow_anonymous true\npsk_hint weir\npsk_file " + keys +
                          "\n");
  auto options = with_key(broker, "camera", "abcdef0123456789");
  options.host = "localhost";
  options.connect_timeout = 60s;
  const auto began = std::chrono::steady_clock::now();
  expect_exchange(options);
  EXPECT_LT(std::chrono::steady_clock::now() - began, 30s);
}

TEST_P(BrokerTls, Passwords) {
  const std::string passwords = files_.file("passwords");
  test::Process made({"mosquitto_passwd", "-b", "-c", passwords, "camera", "secret"});
  ASSERT_EQ(made.wait(), 0);
  const TestBroker broker("user root\nallow_anonymous false\npassword_file " + passwords + "\n");
  expect_exchange(with_password(broker, "camera", "secret"));
  for (const auto& wrong : {with_password(broker, "camera", "Secret"),
                            with_password(broker, "door", "secret"), with_password(broker, "", "")})
    expect_refused(wrong, "does not accept the client", "fix: set user and password");
}

TEST_P(BrokerTls, ConnectsAgainWithTls) {
  TestBroker broker(files_.settings("broker"));
  const auto client = BrokerClient::open(options(broker));
  ASSERT_TRUE(client);
  broker.stop();
  EXPECT_TRUE(becomes_true([&] { return !(*client)->is_connected(); }, "a lost connection"));
  broker.start();
  EXPECT_TRUE(becomes_true([&] { return (*client)->is_connected(); }, "a connection"));
}

INSTANTIATE_TEST_SUITE_P(Version, BrokerTls, ::testing::Values(MqttVersion::V311, MqttVersion::V5),
                         [](const auto& info) {
                           return info.param == MqttVersion::V5 ? "Mqtt5" : "Mqtt311";
                         });

}  // namespace broker_tls_test
}  // namespace weir::transport
