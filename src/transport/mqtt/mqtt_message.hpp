// Messages of a broker, and what connects to one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "weir/result.hpp"

namespace weir::transport {

// Properties of a message of MQTT 5. Version 3.1.1 has none of them.
struct MqttProperties {
  std::string content_type{}, response_topic{};
  std::vector<std::byte> correlation_data{};
  std::optional<uint32_t> expiry{};  // seconds; on a received message what is left of them
  std::vector<std::pair<std::string, std::string>> user{};

  // The first user property of that name.
  std::optional<std::string_view> find(std::string_view name) const;
  // The memory that they need.
  size_t bytes() const;
};

// A received message.
struct MqttMessage {
  std::string topic{};
  std::vector<std::byte> payload{};
  bool retained = false;
  MqttProperties properties{};

  // The memory that it needs.
  size_t bytes() const { return topic.size() + payload.size() + properties.bytes(); }
};

// A message to publish; the payload must live as long as the call.
struct Publication {
  std::string topic{};
  std::span<const std::byte> payload{};
  int qos = 0;
  bool retain = false;
  MqttProperties properties{};
};

// A message that the broker publishes for a client whose connection ends without a goodbye.
struct MqttWill {
  std::string topic{};
  std::vector<std::byte> payload{};
  int qos = 1;
  bool retain = true;
};

enum class MqttVersion : uint8_t { V311, V5 };

struct BrokerTls {
  std::string ca{}, cert{}, key{};    // PEM files
  std::string psk{}, psk_identity{};  // a pre-shared key in hexadecimal digits, instead of files
  bool system_authorities = false;    // without `ca`: those of the operating system

  bool is_enabled() const { return !ca.empty() || !psk.empty() || system_authorities; }
};

struct BrokerOptions {
  std::string host = "127.0.0.1";
  uint16_t port = 1883;
  std::string address_properties = "host and port";  // named in errors
  std::string client_id{};                           // "" = a unique one
  MqttVersion version = MqttVersion::V311;
  bool clean_session = true;
  int keep_alive = 60;  // seconds
  std::string user{}, password{};
  BrokerTls tls{};
  std::optional<MqttWill> will{};
  std::chrono::milliseconds connect_timeout{5000};

  // Messages that wait for receive(). Beyond half of it, a client that subscribed with QoS 1 or 2
  // reads no more for a while; beyond all of it, the oldest message is dropped and counted.
  size_t max_received_messages = 64;
  size_t max_received_bytes = size_t{64} << 20;
  // Messages given to the library and not sent yet (QoS 0) or not acknowledged (QoS 1 and 2).
  size_t max_sent_messages = 20;
  size_t max_sent_bytes = size_t{64} << 20;
  uint16_t receive_maximum = 16;  // MQTT 5: messages of QoS 1 and 2 that the broker may send ahead

  // Takes messages in place of receive(), in the client's thread; must not block or throw.
  std::function<void(MqttMessage)> on_message{};
  // Called in the client's thread for the first packet of the broker that ended a connection
  // because it cannot be read (MQTT 5).
  std::function<void(const Error&)> on_invalid_packet{};
};

// OPTION_VALUE for a topic to publish to that is empty, longer than 65535 bytes, not UTF-8 or
// contains `+`, `#` or NUL. `property` is named in the error.
Status check_topic(std::string_view property, std::string_view topic);
// The same for a filter to subscribe to, which may have `+` and `#` as levels.
Status check_topic_filter(std::string_view property, std::string_view filter);

}  // namespace weir::transport
