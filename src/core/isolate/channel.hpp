// Channel: sends and receives whole messages over a socket to another process, with a time-out and
// supervision of that process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <span>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/isolate/adaptive_poll.hpp"
#include "core/isolate/message.hpp"
#include "machine/descriptor.hpp"

namespace weir::isolate {

enum class Passage {
  Done,
  Ended,       // the other end is closed or its process has ended
  TimedOut,    // the deadline has passed
  Cancelled,   // `stop` or `cancel` became readable
  Unreadable,  // not a valid message
};

struct Message {
  Kind kind{};
  std::vector<std::byte> body;
  io::Descriptor descriptor;  // received with the message
};

// Used by one thread at a time.
class Channel {
 public:
  Channel() = default;
  // `process` (a pidfd), `stop` and `cancel` are borrowed; -1 = none.
  explicit Channel(io::Descriptor socket, int process = -1, int stop = -1, int cancel = -1)
      : socket_(std::move(socket)), process_(process), stop_(stop), cancel_(cancel) {}

  void set_cancel(int cancel) noexcept { cancel_ = cancel; }
  // Sends `descriptor` with the message if it is >= 0.
  Passage send(std::span<const std::byte> message, const io::Deadline& deadline,
               int descriptor = -1);
  // Fills `out`, reusing its memory.
  Passage receive(const io::Deadline& deadline, Message* out);

 private:
  Passage wait(short events, const io::Deadline& deadline) const;
  // Polls for data until `look_until`, then sleeps.
  Passage receive_bytes(std::span<std::byte> into, const io::Deadline& deadline,
                        std::chrono::steady_clock::time_point look_until, io::Descriptor* came);

  io::Descriptor socket_;
  AdaptivePoll usual_;  // for messages
  int process_ = -1, stop_ = -1, cancel_ = -1;
};

}  // namespace weir::isolate
