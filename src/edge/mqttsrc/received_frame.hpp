// What a message of a broker says about its frame, in both protocols of mqttsink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "transport/mqtt/mqtt_message.hpp"
#include "weir/result.hpp"

namespace weir {

struct MqttFrameHeader {
  std::string caps{};
  size_t offset = 0;            // of the first memory in the payload
  std::vector<size_t> sizes{};  // of the memories, which are consecutive
  bool on_time = true;          // false: sent before this pipeline began, or its PTS is negative
  std::optional<uint64_t> pts{}, dts{}, duration{};
  int64_t base_epoch = 0, sent_epoch = 0;  // ns
  std::optional<uint64_t> sequence{};      // MQTT 5
};

// The header of 1024 bytes. PEER_MESSAGE_INVALID as of wire::parse_mqtt_header().
Result<MqttFrameHeader> frame_from_header(const transport::MqttMessage& message,
                                          int64_t own_base_epoch);
// The user properties of MQTT 5. PEER_MESSAGE_INVALID without `caps`, for numbers that cannot be
// read, and for sizes that are not those of the payload. Without epochs the times stay as they are.
Result<MqttFrameHeader> frame_from_properties(const transport::MqttMessage& message,
                                              int64_t own_base_epoch);

}  // namespace weir
