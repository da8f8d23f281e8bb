// SendQueue: messages that wait until a socket takes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "core/io/deadline.hpp"

namespace weir::edge {

struct QueueLimits {
  size_t frames = 16;
  uint64_t bytes = uint64_t{256} << 20;
  std::chrono::milliseconds full_for{10000};  // a peer whose queue is full so long is removed
};

// A frame that is sent, to several peers maybe.
struct SharedMessage {
  std::vector<std::byte> header;  // without the id of a client
  std::vector<std::span<const std::byte>> memories;
  std::shared_ptr<const void> owner;  // of the memories
  uint64_t bytes = 0;                 // of all
};

// One thread at a time. Nothing here blocks.
class SendQueue {
 public:
  // A whole message.
  void push(std::vector<std::byte> message);
  // `header`: of this peer, instead of that in `message`. False: the queue is full.
  bool push(std::vector<std::byte> header, std::shared_ptr<const SharedMessage> message,
            const QueueLimits& limits);
  // Sends what the socket takes. False: the connection has failed.
  bool send(int socket);

  bool empty() const noexcept { return queue_.empty(); }
  size_t size() const noexcept { return queue_.size(); }
  // Whether a part of a message has been sent, so that no other may be sent now.
  bool is_within_message() const noexcept { return sent_ > 0; }
  // When push() failed first since it succeeded; nullopt: it has not.
  const io::Deadline& full_since() const noexcept { return full_since_; }
  // Since when the socket has taken nothing although messages wait; nullopt: none wait.
  const io::Deadline& waiting_since() const noexcept { return waiting_since_; }

 private:
  struct Queued {
    std::vector<std::byte> header;
    std::shared_ptr<const SharedMessage> message;  // null: `header` is a whole message
    uint64_t bytes = 0;
  };
  void add(Queued queued);
  void drop_sent(size_t count);

  std::deque<Queued> queue_;
  size_t sent_ = 0;  // bytes of the first message
  uint64_t queued_bytes_ = 0;
  io::Deadline full_since_, waiting_since_;
};

}  // namespace weir::edge
