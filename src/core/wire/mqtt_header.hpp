// The 1024-byte header of messages of mqttsink, and the times of its stream
// (docs/compatibility/io.md 7.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::wire {

inline constexpr size_t kMqttHeaderBytes = 1024;
inline constexpr size_t kMaxMqttMemories = 16;
inline constexpr size_t kMaxMqttCapsBytes = 512;  // with the NUL

// Where the machine of the sender has the fields.
enum class MqttAlignment : uint8_t { Bits64, Arm32, I386 };

struct MqttHeader {
  std::vector<uint64_t> sizes{};       // of the memories
  int64_t base_time_epoch = 0;         // ns: the base time of the sender's pipeline, as Unix epoch
  int64_t sent_time_epoch = 0;         // ns
  std::optional<uint64_t> duration{};  // ns, as the next two
  std::optional<uint64_t> dts{};
  std::optional<uint64_t> pts{};
  std::string caps{};
};

// Reads the first 1024 bytes. PEER_MESSAGE_INVALID for fewer bytes, more than 16 memories, and caps
// without NUL.
Result<MqttHeader> parse_mqtt_header(std::span<const std::byte> bytes,
                                     MqttAlignment alignment = MqttAlignment::Bits64);

// The header of a machine of 64 bits. LIMIT_EXCEEDED for more than 16 memories and for caps of more
// than 511 characters, OPTION_VALUE for caps with a NUL.
Result<std::vector<std::byte>> write_mqtt_header(const MqttHeader& header);

// The memories that follow the header in `payload`. PEER_MESSAGE_INVALID if the payload is shorter
// than the sizes. Bytes after the last memory are ignored.
Result<std::vector<std::span<const std::byte>>> mqtt_memories(const MqttHeader& header,
                                                              std::span<const std::byte> payload);

struct MqttTimes {
  std::optional<uint64_t> dts;
  std::optional<uint64_t> pts;
};
// The times in a pipeline whose base time is `own_base_epoch` (ns, Unix epoch). Nullopt for a
// message that must be dropped: it was sent before that time, or its PTS would be negative.
std::optional<MqttTimes> times_of_receiver(const MqttHeader& header, int64_t own_base_epoch);

}  // namespace weir::wire
