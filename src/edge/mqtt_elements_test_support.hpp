// MqttElements: mqttsink, mqttsrc and plain clients with a mosquitto.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "elements/tests/pipeline_test_support.hpp"
#include "says.hpp"
#include "transport/mqtt/broker_client.hpp"
#include "transport/mqtt/broker_test_support.hpp"
#include "transport/mqtt/ntp_time.hpp"

namespace weir::test {

using namespace std::chrono_literals;
using transport::BrokerClient;
using transport::MqttMessage;
using transport::MqttProperties;
using transport::MqttVersion;
using Bytes8 = std::vector<std::byte>;

inline constexpr char kMqttCaps[] =
    "other/tensor,dimension=(string)4:1:1:1,type=(string)uint8,framerate=(fraction)30/1";

template <class T>
inline T at(const Bytes8& bytes, size_t offset) {
  T out{};
  if (offset + sizeof out <= bytes.size()) std::memcpy(&out, bytes.data() + offset, sizeof out);
  return out;
}
inline Bytes8 bytes(std::string_view text) {
  const auto span = std::as_bytes(std::span(text.data(), text.size()));
  return {span.begin(), span.end()};
}
// A message as docs/compatibility/io.md 7.5 describes it, with one memory of 4 bytes.
inline Bytes8 message_of_page(const std::string& caps, int64_t base, int64_t sent, uint64_t pts) {
  Bytes8 out(1024 + 4);
  const auto put = [&](size_t offset, const auto& value) {
    std::memcpy(out.data() + offset, &value, sizeof value);
  };
  put(0, uint32_t{1});
  put(8, uint64_t{4});
  put(136, base);
  put(144, sent);
  put(152, UINT64_MAX);
  put(160, UINT64_MAX);
  put(168, pts);
  std::memcpy(out.data() + 176, caps.data(), caps.size());
  put(1024, std::array<uint8_t, 4>{1, 2, 3, 4});
  return out;
}

class MqttElements : public BrokerTest {
 protected:
  void SetUp() override {
    BrokerTest::SetUp();
    if (!IsSkipped()) broker_ = std::make_unique<TestBroker>();
  }
  std::unique_ptr<BrokerClient> client(MqttVersion version = MqttVersion::V5) const {
    transport::BrokerOptions options;
    options.port = broker_->port();
    options.version = version;
    return *BrokerClient::open(options);
  }
  std::string sink(const std::string& options) const {
    return "mqttsink name=sink port=" + broker_->port_text() + " " + options;
  }
  std::string source(const std::string& options) const {
    return "mqttsrc name=source port=" + broker_->port_text() + " " + options;
  }
  static std::string frames(int number) {
    return "videotestsrc pattern=white is-live=true num-buffers=" + std::to_string(number) +
           " ! video/x-raw,format=GRAY8,width=4,height=1,framerate=100/1 ! tensor_converter ! "
           "other/tensor,dimension=(string)1:4:1:1,type=(string)uint8 ! ";
  }
  static void publish(BrokerClient& client, const Bytes8& payload, MqttProperties properties = {}) {
    ASSERT_TRUE(client.publish(
        {.topic = "t", .payload = payload, .qos = 1, .properties = std::move(properties)}, 30s));
  }
  static MqttProperties frame(uint64_t seq) {
    return {.user = {{"caps", kMqttCaps}, {"seq", std::to_string(seq)}, {"base-epoch", "1"}}};
  }
  std::unique_ptr<TestBroker> broker_;
};

}  // namespace weir::test
