// MessageConnection: reads the messages of one connection with few calls of the kernel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/wire/edge_conversation.hpp"
#include "core/wire/message_reader.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::edge {

// One thread at a time. Nothing here blocks.
class MessageConnection {
 public:
  // Without `form` the first bytes of the peer decide it.
  MessageConnection(Descriptor socket, wire::Side side, const wire::MessageLimits& limits,
                    std::optional<wire::HeaderForm> form = {})
      : socket_(std::move(socket)), reader_(limits, form), conversation_(side) {}

  int socket() const noexcept { return socket_.get(); }
  std::optional<wire::HeaderForm> form() const noexcept { return reader_.form(); }
  uint64_t bytes_received() const noexcept { return bytes_received_; }

  enum class Read {
    Message,  // `action` and `message`
    Nothing,  // a message is not there or not complete
    Closed,   // by the peer, or broken
  };
  struct Step {
    Read read;
    wire::Action action = wire::Action::Ignore;
    wire::EdgeMessage message{};
  };
  // Reads up to the end of the next message. PEER_MESSAGE_INVALID.
  Result<Step> read();
  // Whether bytes of a further message have been read: the socket need not be readable for read().
  bool has_read_ahead() const noexcept { return begin_ < end_; }

  // Whether only silence of 200 ms decides the form of what has arrived.
  bool is_undecided() const noexcept { return !reader_.form() && !reader_.at_start(); }
  // There was such a silence. PEER_MESSAGE_INVALID.
  Status silence() { return reader_.silence(); }

 private:
  Status use_ahead();
  // Nullopt if bytes arrived.
  Result<std::optional<Read>> receive();

  Descriptor socket_;
  wire::MessageReader reader_;
  wire::Conversation conversation_;
  // What was read after the part of a message that the reader had room for: with it a small message
  // is read at once, and the end of a large one with its memories.
  std::array<std::byte, 16384> ahead_{};
  size_t begin_ = 0, end_ = 0;
  uint64_t bytes_received_ = 0;
};

}  // namespace weir::edge
