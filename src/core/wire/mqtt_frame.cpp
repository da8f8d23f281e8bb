// Frames that edgesink publishes with connect-type=MQTT, and the topics of MQTT and HYBRID
// (docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_frame.hpp"

#include <algorithm>
#include <array>

#include "core/wire/little_endian.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr uint32_t kMqttMagic = 0xeddaedda;
constexpr size_t kVersionOffset = 8;

struct MqttLayout {
  size_t bytes;
  size_t entries;
  HeaderForm same_as;  // has the same version and limits
  size_t count_offset;
  size_t sizes_offset;
  size_t metadata_offset;
};

// The newest first: a payload that fits several forms is of the newest.
constexpr std::array<MqttForm, 3> kForms{MqttForm::Bytes2080, MqttForm::Bytes160,
                                         MqttForm::Bytes144};

const MqttLayout& get_layout(MqttForm form) {
  static constexpr std::array<MqttLayout, 3> kLayouts{{
      {144, 16, HeaderForm::Bytes160, 4, 8, 136},
      {160, 16, HeaderForm::Bytes168, 16, 24, 152},
      {2080, 256, HeaderForm::Bytes2088, 16, 24, 2072},
  }};
  return kLayouts[static_cast<size_t>(form)];
}

bool has_version(const MqttLayout& layout) {
  return wire::get_layout(layout.same_as).version_key != 0;
}

// The sizes of the memories and of the metadata, if they and the header are the whole payload.
std::optional<std::vector<uint64_t>> parse_sizes(const MqttLayout& layout,
                                                 std::span<const std::byte> payload) {
  if (payload.size() < layout.bytes) return std::nullopt;
  const auto count = read_little<uint32_t>(payload, layout.count_offset);
  if (count == 0 || count > layout.entries) return std::nullopt;
  if (has_version(layout) &&
      !version_may_have(read_little<uint64_t>(payload, kVersionOffset), layout.same_as))
    return std::nullopt;
  std::vector<uint64_t> sizes;
  for (size_t i = 0; i < count; ++i)
    sizes.push_back(read_little<uint64_t>(payload, layout.sizes_offset + 8 * i));
  sizes.push_back(read_little<uint64_t>(payload, layout.metadata_offset));
  uint64_t left = payload.size() - layout.bytes;
  for (const uint64_t size : sizes) {
    if (size > left) return std::nullopt;
    left -= size;
  }
  if (left != 0) return std::nullopt;
  return sizes;
}

Status check_limits(std::span<const std::byte> payload, const MessageLimits& limits) {
  if (payload.size() < sizeof kMqttMagic || read_little<uint32_t>(payload, 0) != kMqttMagic)
    return peer_error("an MQTT message is not a frame of edgesink",
                      std::to_string(payload.size()) + " bytes without the magic number 0xeddaedda",
                      "a message of edgesink connect-type=MQTT",
                      "check topic, and which programs publish to it");
  const uint64_t max = limits.message_bytes + kMaxHeaderBytes;
  if (payload.size() > max)
    return peer_error("an MQTT message is larger than allowed",
                      std::to_string(payload.size()) + " bytes",
                      "at most " + std::to_string(max) + " bytes");
  return ok();
}

Result<MqttFrame> cut(MqttForm form, std::span<const std::byte> payload,
                      const std::vector<uint64_t>& sizes, const MessageLimits& limits) {
  MqttFrame frame{.form = form};
  size_t at = get_layout(form).bytes;
  for (size_t i = 0; i + 1 < sizes.size(); ++i) {
    if (sizes[i] == 0)
      return peer_error("an MQTT message has a memory of 0 bytes", "memory " + std::to_string(i),
                        "at least 1 byte in each memory");
    frame.memories.push_back(payload.subspan(at, static_cast<size_t>(sizes[i])));
    at += static_cast<size_t>(sizes[i]);
  }
  frame.metadata = payload.subspan(at);
  if (frame.metadata.size() > limits.metadata_bytes)
    return peer_error("the metadata of an MQTT message is too long",
                      std::to_string(frame.metadata.size()) + " bytes",
                      "at most " + std::to_string(limits.metadata_bytes) + " bytes");
  return frame;
}

Status check_topic(std::string_view name, std::string_view text, std::string_view forbidden) {
  if (!text.empty() && text.find_first_of(forbidden) == std::string_view::npos) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = std::string(name) + " cannot be part of an MQTT topic",
               .offered = quoted_text(text),
               .needed = "at least one character, and none of " + quoted_text(forbidden),
               .fix = name == "topic" ? "topic=objects" : ""};
}

constexpr std::string_view kNotInTopic("+#\0", 3);
constexpr std::string_view kNotInId("+#/\0", 4);

}  // namespace

Result<MqttFrame> parse_mqtt_frame(std::span<const std::byte> payload,
                                   const MessageLimits& limits) {
  if (auto status = check_limits(payload, limits); !status) return status.error();
  for (const auto form : kForms)
    if (const auto sizes = parse_sizes(get_layout(form), payload))
      return cut(form, payload, *sizes, limits);
  return peer_error("an MQTT message does not have the length that its header declares",
                    std::to_string(payload.size()) + " bytes",
                    "the header (2080, 160 or 144 bytes), its memories and metadata",
                    "check whether the broker or a bridge cuts messages, and which version of "
                    "NNStreamer publishes");
}

Result<std::vector<std::byte>> write_mqtt_frame_header(MqttForm form,
                                                       std::span<const uint64_t> sizes,
                                                       uint64_t metadata_bytes) {
  const auto& layout = get_layout(form);
  if (sizes.empty())
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a frame without memories cannot be published",
                 .offered = "0 memories",
                 .needed = "at least 1 memory",
                 .fix = "check the element that makes the frame"};
  // The limits are those of the header for TCP.
  auto checked = write_header(layout.same_as, {.command = Command::TransferData,
                                               .sizes = {sizes.begin(), sizes.end()},
                                               .metadata_bytes = metadata_bytes});
  if (!checked) return checked.error();
  std::vector<std::byte> out(layout.bytes);
  write_little(std::span(out), 0, kMqttMagic);
  if (has_version(layout))
    write_little(std::span(out), kVersionOffset, wire::get_layout(layout.same_as).version_key);
  write_little(std::span(out), layout.count_offset, static_cast<uint32_t>(sizes.size()));
  for (size_t i = 0; i < sizes.size(); ++i)
    write_little(std::span(out), layout.sizes_offset + 8 * i, sizes[i]);
  write_little(std::span(out), layout.metadata_offset, metadata_bytes);
  return out;
}

Result<std::string> announcement_topic(std::string_view id, std::string_view topic) {
  if (auto status = check_topic("id", id, kNotInId); !status) return status.error();
  if (auto status = check_topic("topic", topic, kNotInTopic); !status) return status.error();
  return "edge/inference/device-" + std::string(id) + "/" + std::string(topic) + "/";
}

Result<std::string> announcement_filter(std::string_view topic) {
  if (auto status = check_topic("topic", topic, kNotInTopic); !status) return status.error();
  return "edge/inference/+/" + std::string(topic) + "/#";
}

std::vector<std::byte> announcement_payload(const HostAddress& address) {
  const std::string text = address.to_string();
  const auto bytes = std::as_bytes(std::span(text.c_str(), text.size() + 1));
  return {bytes.begin(), bytes.end()};
}

Result<std::optional<HostAddress>> parse_announcement(std::span<const std::byte> payload) {
  if (payload.empty()) return std::optional<HostAddress>{};
  const auto text = text_of_memory(payload);
  if (!text) return text.error();
  auto address = parse_host_address(*text);
  if (!address) return address.error();
  return std::optional(*std::move(address));
}

}  // namespace weir::wire
