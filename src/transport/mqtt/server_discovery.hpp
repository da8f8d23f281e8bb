// How servers of connect-type=HYBRID are announced by a broker, and how clients find them
// (docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/wire/announced_servers.hpp"
#include "core/wire/edge_capability.hpp"
#include "transport/mqtt/broker_client.hpp"
#include "transport/wake_event.hpp"

namespace weir::transport {

// The retained address of a server. The broker withdraws it when the connection of this object
// ends, also when the process is killed.
class ServerAnnouncement {
 public:
  // Connects and announces `address` as server `id` of `topic`. An empty host stands for the
  // address by which this machine reaches the broker. Errors as of BrokerClient::open() and
  // wire::announcement_topic().
  static Result<std::unique_ptr<ServerAnnouncement>> open(BrokerOptions options,
                                                          const std::string& id,
                                                          const std::string& topic,
                                                          wire::HostAddress address);
  // The same, but clients find the server only after announce().
  static Result<std::unique_ptr<ServerAnnouncement>> connect(BrokerOptions options,
                                                             const std::string& id,
                                                             const std::string& topic,
                                                             wire::HostAddress address);
  // BROKER_UNREACHABLE; CANCELLED after interrupt(true).
  Status announce();
  // Ends a call of announce() that waits, until it is called with false. Any thread.
  void interrupt(bool interrupted) { client_->interrupt(interrupted); }
  // Withdraws the address, waiting up to 1 s for the broker.
  ~ServerAnnouncement();

  const wire::HostAddress& address() const noexcept { return address_; }
  bool is_connected() const { return client_->is_connected(); }

 private:
  ServerAnnouncement(std::unique_ptr<BrokerClient> client, std::string topic,
                     wire::HostAddress address);
  const std::unique_ptr<BrokerClient> client_;
  const std::string topic_;
  const wire::HostAddress address_;
};

// The servers that a broker announces for a topic, at most 256. Thread-safe, but one thread waits.
class ServerDirectory {
 public:
  // Connects and subscribes. Errors as of BrokerClient::open(), subscribe() and
  // wire::announcement_filter().
  static Result<std::unique_ptr<ServerDirectory>> open(BrokerOptions options,
                                                       const std::string& topic);

  // Oldest announcement first. A server that announced again is the last one.
  std::vector<wire::AnnouncedServers::Server> servers() const;
  // Grows with each announcement and withdrawal.
  uint64_t version() const;
  // Waits until version() is another than `known`. False after the deadline, and when the borrowed
  // descriptor `cancel` is readable; -1 = none.
  bool wait_for_change(uint64_t known, const io::Deadline& deadline, int cancel);
  // Announcements that were not addresses, or one server too many.
  uint64_t refused() const;

 private:
  ServerDirectory() = default;
  void update(const MqttMessage& message);

  mutable std::mutex mutex_;  // guards the members up to client_
  WakeEvent changed_;
  wire::AnnouncedServers servers_;
  uint64_t version_ = 0, refused_ = 0;
  std::unique_ptr<BrokerClient> client_;  // ends before what its thread uses
};

}  // namespace weir::transport
