// Which messages a side of an nnstreamer-edge connection accepts in which order
// (docs/compatibility/edge-wire.md 10.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_conversation.hpp"

#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

// Whether this side answers HOST_INFO to a CAPABILITY; the others send the CAPABILITY.
bool receives_capability(Side side) {
  return side == Side::ClientOnA || side == Side::Subscriber;
}

bool receives_frames(Side side) {
  return side == Side::ServerOnA || side == Side::ClientOnB || side == Side::Subscriber;
}

}  // namespace

Conversation::Conversation(Side side) noexcept
    : side_(side), in_handshake_(side != Side::ServerOnB && side != Side::ClientOnB) {}

Result<Action> Conversation::next(Command command) {
  if (command == Command::Error) return Action::Close;
  if (!in_handshake_) {
    const bool is_frame = command == Command::TransferData && receives_frames(side_);
    return is_frame ? Action::ReadFrame : Action::Ignore;
  }
  const auto expected = receives_capability(side_) ? Command::Capability : Command::HostInfo;
  if (command != expected)
    return peer_error("a peer does not complete the handshake", to_string(command),
                      to_string(expected) + " or ERROR");
  in_handshake_ = false;
  return receives_capability(side_) ? Action::ReadCapability : Action::ReadHostInfo;
}

}  // namespace weir::wire
