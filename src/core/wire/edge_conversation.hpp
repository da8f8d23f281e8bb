// Which messages a side of an nnstreamer-edge connection accepts in which order
// (docs/compatibility/edge-wire.md 10.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

#include "core/wire/edge_header.hpp"
#include "weir/result.hpp"

namespace weir::wire {

// This side of a connection. A query has two: A, which the client opens, and B, which the server
// opens to the client's listener for the responses.
enum class Side : uint8_t { ServerOnA, ServerOnB, ClientOnA, ClientOnB, Publisher, Subscriber };

// What to do with a message that arrived.
enum class Action : uint8_t {
  ReadCapability,  // the greeting: answer HOST_INFO, or ERROR if the caps do not fit
  ReadHostInfo,    // the handshake is complete
  ReadFrame,
  Ignore,  // the peer may send it, and it means nothing here
  Close    // the peer closes
};

// The order of the messages of one connection.
class Conversation {
 public:
  explicit Conversation(Side side) noexcept;

  // The action for the next message. PEER_MESSAGE_INVALID for a message that cannot be the one that
  // completes the handshake. After the handshake all but frames and ERROR are ignored, as
  // NNStreamer does: a second HOST_INFO cannot open a second connection.
  Result<Action> next(Command command);
  bool is_in_handshake() const noexcept { return in_handshake_; }

 private:
  const Side side_;
  bool in_handshake_;
};

}  // namespace weir::wire
