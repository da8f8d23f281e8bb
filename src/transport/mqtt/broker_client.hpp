// BrokerClient: a connection to an MQTT broker that is made again when it is lost.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "transport/mqtt/mqtt_message.hpp"
#include "weir/result.hpp"

namespace weir::transport {

struct BrokerCounts {
  uint64_t connections = 0;  // that the broker accepted, so 1 more than reconnections
  uint64_t published = 0;    // QoS 0: sent; QoS 1 and 2: acknowledged
  uint64_t refused = 0;      // messages that the broker did not accept
  uint64_t lost = 0;         // messages of QoS 0 that were not sent when a connection ended
  uint64_t dropped = 0;      // received messages beyond the limits of the queue
};

// Has a thread of its own, which reads, writes and connects again 100 ms to 1 s after a loss. All
// methods are thread-safe; several clients of a process are independent.
class BrokerClient {
 public:
  // Connects. BROKER_UNREACHABLE if no connection can be made within `connect_timeout`,
  // BROKER_REFUSED if the broker does not accept the client, FILE_NOT_FOUND and OPTION_VALUE for
  // options that cannot be used. Without libmosquitto OPTION_VALUE with the package to install.
  static Result<std::unique_ptr<BrokerClient>> open(BrokerOptions options);
  // Says goodbye to the broker, which then does not publish the will. What waits is lost.
  ~BrokerClient();
  BrokerClient(const BrokerClient&) = delete;
  BrokerClient& operator=(const BrokerClient&) = delete;

  // Receives what matches `filter`, also after the next connections. Waits for the broker:
  // BROKER_REFUSED if it does not permit that. QoS 2 of MQTT 5 is received with QoS 1.
  Status subscribe(const std::string& filter, int qos);
  // The next message; nullopt when none came in time, and after interrupt(true).
  std::optional<MqttMessage> receive(std::chrono::milliseconds timeout);
  // Ends calls of receive(), publish() and flush() that wait, until it is called with false.
  void interrupt(bool interrupted);

  // Publishes, waiting up to `timeout` for a connection and for room among the messages in
  // progress. BROKER_UNREACHABLE when there was none, CANCELLED after interrupt(true).
  Status publish(const Publication& publication, std::chrono::milliseconds timeout);
  // Publishes now and after each new connection, because a broker may forget what it retains when
  // it ends. Replaces the publication that was kept for that topic.
  Status keep_published(std::string topic, std::vector<std::byte> payload, int qos,
                        std::chrono::milliseconds timeout);
  // Removes what the broker retains for `topic`, also after interrupt(true), waiting no longer than
  // `timeout`. A broker that is gone publishes the will, or has forgotten the message.
  void remove_retained(const std::string& topic, int qos, std::chrono::milliseconds timeout);
  // Waits until the broker has all messages. False when it took longer.
  bool flush(std::chrono::milliseconds timeout);

  bool is_connected() const;
  // The address of this machine on the connection: what other machines that reach the broker can
  // probably reach. "" without a connection.
  std::string local_address() const;
  BrokerCounts counts() const;

 private:
  class Impl;
  explicit BrokerClient(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

// Whether this build can connect to brokers.
bool has_broker_client();

}  // namespace weir::transport
