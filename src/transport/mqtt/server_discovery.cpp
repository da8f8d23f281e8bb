// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/server_discovery.hpp"

#include <poll.h>

#include "core/wire/mqtt_frame.hpp"

namespace weir::transport {
namespace {

using namespace std::chrono_literals;
constexpr int kQos = 1;
constexpr auto kAnnounceTime = 5s, kConfirmTime = 1s, kWithdrawTime = 1s;

}  // namespace

Result<std::unique_ptr<ServerAnnouncement>> ServerAnnouncement::open(BrokerOptions options,
                                                                     const std::string& id,
                                                                     const std::string& topic,
                                                                     wire::HostAddress address) {
  auto out = connect(std::move(options), id, topic, std::move(address));
  if (!out) return out;
  if (auto status = (*out)->announce(); !status) return status.error();
  return out;
}

Result<std::unique_ptr<ServerAnnouncement>> ServerAnnouncement::connect(BrokerOptions options,
                                                                        const std::string& id,
                                                                        const std::string& topic,
                                                                        wire::HostAddress address) {
  auto whole_topic = wire::announcement_topic(id, topic);
  if (!whole_topic) return whole_topic.error();
  options.will = MqttWill{.topic = *whole_topic, .payload = {}, .qos = kQos, .retain = true};
  auto client = BrokerClient::open(std::move(options));
  if (!client) return client.error();
  if (address.host.empty()) address.host = (*client)->local_address();
  return std::unique_ptr<ServerAnnouncement>(
      new ServerAnnouncement(*std::move(client), *std::move(whole_topic), std::move(address)));
}

ServerAnnouncement::ServerAnnouncement(std::unique_ptr<BrokerClient> client, std::string topic,
                                       wire::HostAddress address)
    : client_(std::move(client)), topic_(std::move(topic)), address_(std::move(address)) {}

Status ServerAnnouncement::announce() {
  auto status =
      client_->keep_published(topic_, wire::announcement_payload(address_), kQos, kAnnounceTime);
  if (status) client_->flush(kConfirmTime);  // a broker that is slow gets it later
  return status;
}

ServerAnnouncement::~ServerAnnouncement() {
  client_->remove_retained(topic_, kQos, kWithdrawTime);
}

Result<std::unique_ptr<ServerDirectory>> ServerDirectory::open(BrokerOptions options,
                                                               const std::string& topic) {
  auto filter = wire::announcement_filter(topic);
  if (!filter) return filter.error();
  std::unique_ptr<ServerDirectory> out(new ServerDirectory);
  options.on_message = [directory = out.get()](const MqttMessage& message) {
    directory->update(message);
  };
  auto client = BrokerClient::open(std::move(options));
  if (!client) return client.error();
  out->client_ = *std::move(client);
  if (auto status = out->client_->subscribe(*filter, kQos); !status) return status.error();
  return out;
}

void ServerDirectory::update(const MqttMessage& message) {
  std::lock_guard lock(mutex_);
  if (!servers_.update(message.topic, message.payload)) {
    ++refused_;
    return;
  }
  ++version_;
  changed_.set();
}

std::vector<wire::AnnouncedServers::Server> ServerDirectory::servers() const {
  std::lock_guard lock(mutex_);
  return servers_.servers();
}

uint64_t ServerDirectory::version() const {
  std::lock_guard lock(mutex_);
  return version_;
}

bool ServerDirectory::wait_for_change(uint64_t known, const io::Deadline& deadline, int cancel) {
  for (;;) {
    changed_.clear();  // before version(), so that no change is missed
    if (version() != known) return true;
    pollfd watched[] = {{changed_.descriptor(), POLLIN, 0}, {cancel, POLLIN, 0}};
    const int ready = poll(watched, 2, io::poll_timeout(deadline));
    if (ready > 0 && watched[1].revents) return false;
    if (ready == 0 && io::is_over(deadline)) return version() != known;
  }
}

uint64_t ServerDirectory::refused() const {
  std::lock_guard lock(mutex_);
  return refused_;
}

}  // namespace weir::transport
