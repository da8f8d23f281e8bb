// MessageConnection: reads the messages of one connection in turns, with few calls of the kernel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/wire/edge_conversation.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::edge {

// One thread at a time.
class MessageConnection {
 public:
  // The bytes that a connection may bring before its thread attends to others, to a time limit or
  // to a stop.
  static constexpr size_t kTurnBytes = size_t{1} << 20;
  // What is read after the end of a message: with it a small message is read at once, and the end
  // of a large one with its memories. A connection that is polled beside others reads none, so that
  // its socket is readable while there is something to read.
  static constexpr size_t kReadAhead = 16384;

  // Without `form` the first bytes of the peer decide it.
  MessageConnection(Descriptor socket, wire::Side side, const wire::MessageLimits& limits,
                    std::optional<wire::HeaderForm> form = {}, size_t read_ahead = kReadAhead)
      : socket_(std::move(socket)),
        reader_(std::in_place, limits, form),
        conversation_(side),
        ahead_(read_ahead) {}

  int socket() const noexcept { return socket_.get(); }
  std::optional<wire::HeaderForm> form() const noexcept { return reader_->form(); }
  uint64_t bytes_received() const noexcept { return bytes_received_; }
  // Bytes of a message that has begun to arrive.
  uint64_t partial_bytes() const noexcept { return partial_bytes_; }
  // Sets the limits of the messages that follow. Precondition: read() returned a message.
  void set_limits(const wire::MessageLimits& limits) { reader_.emplace(limits, form()); }

  enum class Read {
    Message,    // `action`, which is not Ignore, and `message`
    Nothing,    // a message is not there or not complete, or the turn is over
    Closed,     // by the peer, or broken
    Cancelled,  // of wait()
    Late        // of wait(): the deadline passed
  };
  struct Step {
    Read read = Read::Nothing;
    wire::Action action = wire::Action::Ignore;
    wire::EdgeMessage message{};
  };
  // Reads up to the end of the next message that is not ignored. Does not block, and stops when
  // `*turn` bytes have been received, which it takes from it. PEER_MESSAGE_INVALID.
  Result<Step> read(size_t* turn);
  // Waits for the next message. `cancel` is a borrowed descriptor that ends waiting when readable,
  // or -1. Never returns Nothing. PEER_MESSAGE_INVALID.
  Result<Step> wait(const io::Deadline& deadline, int cancel);
  // Whether bytes of a further message have been read: the socket need not be readable for read().
  bool has_read_ahead() const noexcept { return begin_ < end_; }

 private:
  Status use_ahead();
  // Closed, or nullopt if bytes arrived.
  Result<std::optional<Read>> receive(size_t* turn);

  Descriptor socket_;
  std::optional<wire::EdgeMessageReader> reader_;
  wire::Conversation conversation_;
  std::vector<std::byte> ahead_;
  size_t begin_ = 0, end_ = 0;
  uint64_t bytes_received_ = 0, partial_bytes_ = 0;
};

}  // namespace weir::edge
