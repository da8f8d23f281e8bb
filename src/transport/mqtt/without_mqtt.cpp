// BrokerClient of a build without libmosquitto: no client can be opened.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/broker_client.hpp"

namespace weir::transport {

class BrokerClient::Impl {};

bool has_broker_client() {
  return false;
}

Result<std::unique_ptr<BrokerClient>> BrokerClient::open(BrokerOptions options) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "this build of Weir cannot connect to MQTT brokers",
               .offered = "the broker " + options.host + ":" + std::to_string(options.port),
               .needed = "libmosquitto when Weir is built",
               .fix = "apt-get install libmosquitto-dev, then build Weir again"};
}

// No object exists.
BrokerClient::BrokerClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BrokerClient::~BrokerClient() = default;
Status BrokerClient::subscribe(const std::string&, int) {
  return ok();
}
std::optional<MqttMessage> BrokerClient::receive(std::chrono::milliseconds) {
  return std::nullopt;
}
void BrokerClient::interrupt(bool) {}
Status BrokerClient::publish(const Publication&, std::chrono::milliseconds) {
  return ok();
}
Status BrokerClient::keep_published(std::string, std::vector<std::byte>, int,
                                    std::chrono::milliseconds) {
  return ok();
}
void BrokerClient::remove_retained(const std::string&, int, std::chrono::milliseconds) {}
bool BrokerClient::flush(std::chrono::milliseconds) {
  return true;
}
bool BrokerClient::is_connected() const {
  return false;
}
std::string BrokerClient::local_address() const {
  return "";
}
BrokerCounts BrokerClient::counts() const {
  return {};
}

}  // namespace weir::transport
