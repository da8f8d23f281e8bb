// Frames that edgesink publishes with connect-type=MQTT, and the topics of MQTT and HYBRID
// (docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_header.hpp"
#include "weir/result.hpp"

namespace weir::wire {

// Named by the bytes of the header.
enum class MqttForm : uint8_t {
  Bytes144,  // up to 0.2.3
  Bytes160,  // 0.2.4
  Bytes2080  // 0.2.5 and later
};

// Parts of a payload, which must outlive it.
struct MqttFrame {
  MqttForm form = MqttForm::Bytes2080;
  std::vector<std::span<const std::byte>> memories{};
  std::span<const std::byte> metadata{};  // for EdgeMetadata::parse()
};

// Reads a payload; its length decides the form. PEER_MESSAGE_INVALID if no form has this length,
// and for payloads beyond the limits or with a memory of 0 bytes.
Result<MqttFrame> parse_mqtt_frame(std::span<const std::byte> payload, const MessageLimits& limits);

// The header; the memories and the metadata follow it. Errors as of write_header(), and FRAME_SIZE
// without memories.
Result<std::vector<std::byte>> write_mqtt_frame_header(MqttForm form,
                                                       std::span<const uint64_t> sizes,
                                                       uint64_t metadata_bytes);

// `edge/inference/device-ID/TOPIC/`, where a server announces its address and a publisher its
// frames. OPTION_VALUE if `id` or `topic` is empty or contains `+`, `#` or NUL, or `id` a slash.
Result<std::string> announcement_topic(std::string_view id, std::string_view topic);
// `edge/inference/+/TOPIC/#`, which receives them. Errors as of announcement_topic().
Result<std::string> announcement_filter(std::string_view topic);

// `host:port` and a NUL.
std::vector<std::byte> announcement_payload(const HostAddress& address);
// The address; nullopt for an empty payload, by which a server withdraws it. PEER_MESSAGE_INVALID
// as of text_of_memory() and parse_host_address().
Result<std::optional<HostAddress>> parse_announcement(std::span<const std::byte> payload);

}  // namespace weir::wire
