// Channel: whole messages over a socket between two processes, with a time limit and an eye on the
// other process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <span>
#include <vector>

#include "core/isolate/deadline.hpp"
#include "core/isolate/descriptor.hpp"
#include "core/isolate/message.hpp"
#include "core/isolate/usual_wait.hpp"

namespace weir::isolate {

enum class Passage {
  Done,
  Ended,       // the other end is closed, or its process is no more
  TimedOut,    //
  Cancelled,   // `stop` or `cancel` became readable
  Unreadable,  // what came is no message
};

struct Message {
  Kind kind{};
  std::vector<std::byte> body;
  Descriptor descriptor;  // that came along
};

// One thread at a time.
class Channel {
 public:
  Channel() = default;
  // `process` (a pidfd), `stop` and `cancel` are borrowed; -1 = none.
  explicit Channel(Descriptor socket, int process = -1, int stop = -1, int cancel = -1)
      : socket_(std::move(socket)), process_(process), stop_(stop), cancel_(cancel) {}

  void set_cancel(int cancel) noexcept { cancel_ = cancel; }
  // `descriptor` >= 0 goes along.
  Passage send(std::span<const std::byte> message, const Deadline& deadline, int descriptor = -1);
  // Fills `out`, whose memory is used again.
  Passage receive(const Deadline& deadline, Message* out);

 private:
  Passage wait(short events, const Deadline& deadline) const;
  // Sleeps where nothing has come at `look_until`.
  Passage receive_bytes(std::span<std::byte> into, const Deadline& deadline,
                        std::chrono::steady_clock::time_point look_until, Descriptor* came);

  Descriptor socket_;
  UsualWait usual_;  // of messages
  int process_ = -1, stop_ = -1, cancel_ = -1;
};

}  // namespace weir::isolate
