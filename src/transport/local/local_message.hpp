// The messages between the two ends of a local stream: a writer that has frames in shared memory,
// and readers that map it. One message is one packet of a Unix socket (SOCK_SEQPACKET).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "core/isolate/message.hpp"

namespace weir::local {

// Increment it with every change of a message: peers of another version are refused.
inline constexpr uint32_t kProtocol = 1;
inline constexpr uint32_t kMagic = 0x72696577;  // "weir"
inline constexpr size_t kMaxMessageBytes = size_t{64} << 10;
inline constexpr size_t kMaxCapsBytes = kMaxMessageBytes / 2;
inline constexpr uint32_t kMaxPieces = 256;
inline constexpr size_t kMaxMetasInMessage = size_t{32} << 10;  // more travel in a block

enum class Kind : uint32_t {
  // From the reader.
  Hello = 1,  // Greeting
  Release,    // number of a frame: its memory is no longer read
  Leave,      // send no more frames; those held are released as before
  // From the writer.
  Welcome,  // Greeting, u32: frames that the reader may hold
  Block,    // BlockMessage, with a descriptor
  Forget,   // id of a block that no later frame uses
  Caps,     // text
  Frame,    // FrameHead, Piece for each memory, metas
  End,      // the end of the stream
};

struct Greeting {
  uint32_t magic, protocol;
};
struct BlockMessage {
  uint64_t id, bytes;
};

// Nanoseconds, as in a GstBuffer; all ones = none.
struct FrameTimes {
  static constexpr uint64_t kNone = UINT64_MAX;
  uint64_t pts = kNone, dts = kNone, duration = kNone, offset = kNone, offset_end = kNone;
  uint64_t flags = 0;
  bool operator==(const FrameTimes&) const = default;
};
struct FrameHead {
  uint64_t number;  // increases from frame to frame
  FrameTimes times;
  uint32_t pieces;
  uint32_t metas_are_piece;  // 1: the last piece is no memory of the frame but its metas
};
// Where a memory lies.
struct Piece {
  uint64_t block, offset, bytes;
};

struct Opened {
  Kind kind;
  isolate::MessageReader body;
};
// Checks the head of a packet; nullopt if it does not describe exactly these bytes.
inline std::optional<Opened> open_message(std::span<const std::byte> packet) {
  isolate::MessageHead head{};
  if (packet.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, packet.data(), sizeof head);
  const auto body = packet.subspan(sizeof head);
  if (head.bytes != body.size()) return std::nullopt;
  return Opened{static_cast<Kind>(head.kind), isolate::MessageReader(body)};
}

}  // namespace weir::local
