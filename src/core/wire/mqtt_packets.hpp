// Packets of a broker of MQTT 5 as they arrive, without what libmosquitto must not see.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "weir/result.hpp"

namespace weir::wire {

// The properties of one packet: enough for caps and times. As objects, 16 MiB of them
// took 200 MB.
inline constexpr size_t kMaxMqttPropertyBytes = size_t{256} << 10;

// Checks each packet up to the end of its properties before it passes on any of its bytes. Only the
// properties that MQTT 5 defines may come. A message with too many loses them: everyone who may
// publish can send it, and a broker repeats a retained one for each connection. A reason that MQTT
// 5 does not list, in the refusal of a message, is passed on as 0x80, unspecified error:
// libmosquitto would end the connection and send the message again with the next one.
class MqttPacketFilter {
 public:
  // Takes the next bytes of the connection, and appends to `out` those that can be passed on.
  // PEER_MESSAGE_INVALID for a packet that is none, and from then on.
  Status feed(std::span<const std::byte> bytes, std::vector<std::byte>* out);
  // Messages that lost their properties.
  uint64_t stripped() const noexcept { return stripped_; }
  // Packets whose reason was replaced.
  uint64_t replaced() const noexcept { return replaced_; }

 private:
  enum class Part { Type, Length, Head, Skipped, Rest };
  using Bytes = std::span<const std::byte>;

  Status take_length(std::vector<std::byte>* out);
  Status take_head(Bytes* bytes, std::vector<std::byte>* out);
  // Where the length of the properties begins; more than the head has if that has not come.
  size_t begin_of_properties() const;
  // The size of the head; more than it has while its end is not known.
  Result<size_t> head_size() const;
  void skip(Bytes* bytes);
  void pass_rest(Bytes* bytes, std::vector<std::byte>* out);
  Status strip(size_t properties, std::vector<std::byte>* out);
  void replace_reason();
  Status end_head(std::vector<std::byte>* out);

  Part part_ = Part::Type;
  std::vector<std::byte> start_;  // type and length
  std::vector<std::byte> head_;   // of the packet, up to the end of its properties
  uint8_t type_ = 0;
  uint32_t length_ = 0;            // of what follows `start_`
  size_t left_ = 0, skipped_ = 0;  // bytes that have not come: of the packet, of what it loses
  uint64_t stripped_ = 0, replaced_ = 0;
  Status status_ = ok();
};

}  // namespace weir::wire
