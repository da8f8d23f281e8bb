// The 1024-byte header of messages of mqttsink, and the times of its stream
// (docs/compatibility/io.md 7.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_header.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "core/wire/little_endian.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr uint64_t kNone = UINT64_MAX;
__extension__ using Wide = __int128;

struct MqttHeaderLayout {
  size_t size_bytes;  // of each size
  size_t sizes;
  size_t times;  // base time, sent time, duration, DTS, PTS: 8 bytes each
  size_t caps;
};

const MqttHeaderLayout& get_layout(MqttAlignment alignment) {
  static constexpr std::array<MqttHeaderLayout, 3> kLayouts{{
      {8, 8, 136, 176},  // Bits64
      {4, 4, 72, 112},   // Arm32
      {4, 4, 68, 108},   // I386
  }};
  return kLayouts[static_cast<size_t>(alignment)];
}

std::optional<uint64_t> to_time(uint64_t value) {
  return value == kNone ? std::nullopt : std::optional(value);
}

Error header_error(std::string what, std::string offered, std::string needed) {
  return peer_error("an MQTT message " + std::move(what), std::move(offered), std::move(needed),
                    "check sub-topic, and that an mqttsink of a 64-bit machine publishes to it");
}

Error send_error(Code code, std::string what, std::string offered, std::string needed,
                 std::string fix) {
  return {.code = code,
          .what = std::move(what),
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = std::move(fix)};
}

Status check_sendable(const MqttHeader& header) {
  if (header.sizes.size() > kMaxMqttMemories)
    return send_error(Code::LIMIT_EXCEEDED, "a buffer has more memories than an MQTT message",
                      std::to_string(header.sizes.size()) + " memories",
                      "at most " + std::to_string(kMaxMqttMemories),
                      "merge tensors with tensor_merge before mqttsink");
  if (header.caps.size() >= kMaxMqttCapsBytes)
    return send_error(Code::LIMIT_EXCEEDED, "caps are too long for an MQTT message",
                      std::to_string(header.caps.size()) + " characters",
                      "at most " + std::to_string(kMaxMqttCapsBytes - 1),
                      "shorten the caps, for example with other/tensors,format=flexible");
  if (header.caps.find('\0') != std::string::npos)
    return send_error(Code::OPTION_VALUE, "caps contain a NUL", quoted_text(header.caps),
                      "caps without NUL", "check the element that makes the caps");
  return ok();
}

// `time` moved by `shift`; nullopt if it would be negative or beyond 64 bits.
std::optional<uint64_t> moved(uint64_t time, Wide shift) {
  const Wide sum = shift + time;
  if (sum < 0 || sum >= static_cast<Wide>(kNone)) return std::nullopt;
  return static_cast<uint64_t>(sum);
}

}  // namespace

Result<MqttHeader> parse_mqtt_header(std::span<const std::byte> bytes, MqttAlignment alignment) {
  if (bytes.size() < kMqttHeaderBytes)
    return header_error("is too short for its header", std::to_string(bytes.size()) + " bytes",
                        "at least 1024 bytes");
  const auto& layout = get_layout(alignment);
  const auto count = read_little<uint32_t>(bytes, 0);
  if (count > kMaxMqttMemories)
    return header_error("has too many memories", std::to_string(count) + " memories",
                        "at most " + std::to_string(kMaxMqttMemories));
  MqttHeader header;
  for (size_t i = 0; i < count; ++i) {
    const size_t at = layout.sizes + layout.size_bytes * i;
    header.sizes.push_back(layout.size_bytes == 8 ? read_little<uint64_t>(bytes, at)
                                                  : read_little<uint32_t>(bytes, at));
  }
  const auto times = bytes.subspan(layout.times);
  header.base_time_epoch = read_little<int64_t>(times, 0);
  header.sent_time_epoch = read_little<int64_t>(times, 8);
  header.duration = to_time(read_little<uint64_t>(times, 16));
  header.dts = to_time(read_little<uint64_t>(times, 24));
  header.pts = to_time(read_little<uint64_t>(times, 32));
  const std::string_view caps(reinterpret_cast<const char*>(bytes.data()) + layout.caps,
                              kMaxMqttCapsBytes);
  const size_t end = caps.find('\0');
  if (end == std::string_view::npos)
    return header_error("has caps without an end", quoted_text(caps), "a NUL within 512 bytes");
  header.caps = caps.substr(0, end);
  return header;
}

Result<std::vector<std::byte>> write_mqtt_header(const MqttHeader& header) {
  if (auto status = check_sendable(header); !status) return status.error();
  const auto& layout = get_layout(MqttAlignment::Bits64);
  std::vector<std::byte> out(kMqttHeaderBytes);
  write_little(std::span(out), 0, static_cast<uint32_t>(header.sizes.size()));
  for (size_t i = 0; i < header.sizes.size(); ++i)
    write_little(std::span(out), layout.sizes + 8 * i, header.sizes[i]);
  const auto times = std::span(out).subspan(layout.times);
  write_little(times, 0, header.base_time_epoch);
  write_little(times, 8, header.sent_time_epoch);
  write_little(times, 16, header.duration.value_or(kNone));
  write_little(times, 24, header.dts.value_or(kNone));
  write_little(times, 32, header.pts.value_or(kNone));
  std::memcpy(out.data() + layout.caps, header.caps.data(), header.caps.size());
  return out;
}

Result<std::vector<std::span<const std::byte>>> mqtt_memories(const MqttHeader& header,
                                                              std::span<const std::byte> payload) {
  std::vector<std::span<const std::byte>> memories;
  auto rest = payload.subspan(std::min(kMqttHeaderBytes, payload.size()));
  for (size_t i = 0; i < header.sizes.size(); ++i) {
    const uint64_t size = header.sizes[i];
    if (size > rest.size())
      return header_error("is shorter than its memories",
                          std::to_string(rest.size()) + " bytes for memory " + std::to_string(i),
                          std::to_string(size) + " bytes");
    memories.push_back(rest.first(static_cast<size_t>(size)));
    rest = rest.subspan(static_cast<size_t>(size));
  }
  return memories;
}

std::optional<MqttTimes> times_of_receiver(const MqttHeader& header, int64_t own_base_epoch) {
  if (header.sent_time_epoch < own_base_epoch) return std::nullopt;
  const Wide shift = Wide{header.base_time_epoch} - own_base_epoch;
  MqttTimes times;
  if (header.pts) {
    times.pts = moved(*header.pts, shift);
    if (!times.pts) return std::nullopt;
  }
  if (header.dts) times.dts = moved(*header.dts, shift);
  return times;
}

}  // namespace weir::wire
