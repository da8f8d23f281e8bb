// The elements that use brokers, with TLS, certificates of clients, pre-shared keys and passwords.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "transport/mqtt/broker_certificates.hpp"

namespace edge_broker_login_test {

using namespace weir::test;

constexpr char kCaps[] =
    "other/tensor,dimension=(string)1:4:1:1,type=(string)uint8,framerate=100/1";

class BrokerLogin : public BrokerTest {
 protected:
  // The properties for a broker with passwords and certificates of clients.
  std::string login(const std::string& ca = "ca.pem", const std::string& password = "secret") {
    return " user=camera password=" + password + " tls-ca=" + files_.file(ca) +
           " tls-cert=" + files_.file("client.pem") + " tls-key=" + files_.file("client.key") + " ";
  }
  std::string strict_settings(const std::string& certificate = "broker") {
    Process made({"mosquitto_passwd", "-b", "-c", files_.file("passwords"), "camera", "secret"});
    EXPECT_EQ(made.wait(), 0);
    return files_.settings(
        certificate, "require_certificate true\npassword_file " + files_.file("passwords") + "\n");
  }
  static std::string mqtt(const TestBroker& broker) {
    return " host=localhost port=" + broker.port_text() + " ";
  }
  static std::string edge(const TestBroker& broker, const std::string& type) {
    return " connect-type=" + type +
           " topic=objects dest-host=localhost dest-port=" + broker.port_text() + " ";
  }
  // A buffer of `sink` reaches `source`. Pipelines, because mqttsrc needs a clock that runs.
  static void expect_exchange(const std::string& sink, const std::string& source) {
    PlayedPipeline receiving(source + " ! fakesink name=end async=false sync=false");
    ASSERT_TRUE(receiving.reaches(GST_STATE_PLAYING));
    PlayedPipeline sending(
        "videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=4,height=1,framerate=100/1 ! "
        "tensor_converter ! " +
        std::string(kCaps) + " ! " + sink);
    gst_element_set_state(sending.get(), GST_STATE_PLAYING);
    EXPECT_TRUE(becomes_true([&] { return receiving.stat("source", "pushed") > 2; }, "buffers"))
        << source;
  }

  const BrokerCertificates files_{};
};

TEST_F(BrokerLogin, StreamsWithCertificatesAndPassword) {
  const TestBroker broker(strict_settings());
  for (const std::string protocol : {"protocol=4", "protocol=5"})
    expect_exchange("mqttsink pub-topic=t " + protocol + mqtt(broker) + login(),
                    "mqttsrc name=source sub-topic=t " + protocol + mqtt(broker) + login());
  expect_exchange("edgesink sync=false" + edge(broker, "MQTT") + login(),
                  "edgesrc name=source" + edge(broker, "MQTT") + login() + "! " + kCaps);
  expect_exchange(
      "edgesink sync=false port=0 wait-connection=true" + edge(broker, "HYBRID") + login(),
      "edgesrc name=source" + edge(broker, "HYBRID") + login() + "! " + kCaps);
}

TEST_F(BrokerLogin, StreamsWithAPreSharedKey) {
  const TestBroker broker("user root\nallow_anonymous true\npsk_hint weir\npsk_file " +
                          files_.text_file("keys", "camera:abcdef0123456789") + "\n");
  const std::string key = " psk=abcdef0123456789 psk-identity=camera ";
  expect_exchange("mqttsink pub-topic=t" + mqtt(broker) + key,
                  "mqttsrc name=source sub-topic=t" + mqtt(broker) + key);
  EXPECT_SAYS(start_error("mqttsink psk=00 psk-identity=camera" + mqtt(broker)),
              "compare psk and psk-identity with the broker's file of keys");
}

TEST_F(BrokerLogin, RefusalsNameTheFix) {
  const TestBroker broker(strict_settings());
  for (const std::string& element :
       {"mqttsink" + mqtt(broker), "mqttsrc sub-topic=t" + mqtt(broker),
        "edgesink port=0" + edge(broker, "MQTT"), "edgesrc" + edge(broker, "MQTT"),
        "edgesink port=0" + edge(broker, "HYBRID"), "edgesrc" + edge(broker, "HYBRID")}) {
    EXPECT_SAYS(start_error(element + login("other.pem")), "WEIR-6006");
    EXPECT_SAYS(start_error(element + login("other.pem")), "fix: set tls-ca to the file of");
    EXPECT_SAYS(start_error(element + login("ca.pem", "wrong")), "fix: set user and password");
    EXPECT_SAYS(start_error(element + "tls-ca=" + files_.file("ca.pem")),
                "fix: set tls-cert and tls-key");
    EXPECT_SAYS(start_error(element + "tls-ca=/none.pem"), "tls-ca=/path/to/file.pem");
  }
}

TEST_F(BrokerLogin, CertificatesThatAreNotTheBrokersNameTheFix) {
  const TestBroker elsewhere(files_.settings("elsewhere"));
  const std::string ca = "tls-ca=" + files_.file("ca.pem");
  EXPECT_SAYS(start_error("mqttsink" + mqtt(elsewhere) + ca), "weir pki issue localhost");
  const TestBroker expired(files_.settings("expired"));
  EXPECT_SAYS(start_error("edgesrc" + edge(expired, "HYBRID") + ca), "its certificate has expired");
}

}  // namespace edge_broker_login_test
