// ReaderLink: one reader as its writer sees it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>

#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/isolate/shared_arena.hpp"
#include "transport/local/local_message.hpp"
#include "transport/local/local_socket.hpp"

namespace weir::local {

// Owners of frames whose release may run other code: destroyed without a lock.
using Garbage = std::vector<std::shared_ptr<const void>>;

// A frame to publish.
struct LocalFrame {
  struct Memory {
    std::shared_ptr<isolate::SharedBlock> block;
    uint64_t offset = 0, bytes = 0;
  };
  uint64_t number = 0;  // set by the publisher
  FrameTimes times;
  std::vector<Memory> memories;       // at most kMaxPieces - 1
  std::vector<std::byte> metas;       // the reader gets them as they are
  std::shared_ptr<const void> owner;  // keeps the memories until every reader released them
  bool metas_are_memory = false;      // the metas are the last one of `memories`
};

// Used under the publisher's lock, but read(). Nothing here blocks.
class ReaderLink {
 public:
  enum class State { Greeting, Reading, Leaving, Gone };

  explicit ReaderLink(Descriptor socket) : socket_(std::move(socket)) {}

  static constexpr size_t kSockets = 1;
  int socket() const noexcept { return socket_.get(); }
  State state() const noexcept { return state_; }
  bool is_gone() const noexcept { return state_ == State::Gone; }
  void set_gone() noexcept { state_ = State::Gone; }
  bool is_full() const noexcept { return full_; }  // the socket takes no more
  void set_room() noexcept { full_ = false; }
  bool has_room(size_t max_held) const noexcept { return !full_ && held_.size() < max_held; }
  bool holds() const noexcept { return !held_.empty(); }
  std::chrono::steady_clock::time_point greeting_ends() const noexcept { return greeting_ends_; }

  // These return false if the message was not sent: is_full() or state() tell why.
  bool welcome(uint32_t max_held);
  bool send_caps(const std::shared_ptr<const std::string>& caps);  // unless it has them; null: none
  bool send_frame(const LocalFrame& frame);                        // unless it has it
  bool send_end();

  // A packet; a reader sends none that is longer.
  struct Message {
    std::array<std::byte, 64> bytes{};
    size_t size = 0;  // 0: it is not a message
  };
  struct Input {
    std::vector<Message> messages;
    bool is_closed = false;
  };
  // Receives what has arrived. One thread, without the lock.
  Input read(const pollfd* events);
  // Handles one message of the reader; nullopt, or why the reader is refused.
  std::optional<std::string> handle(const Message& received, Garbage* garbage);
  void release_all(Garbage* garbage);

 private:
  static constexpr auto kGreetingTime = std::chrono::seconds(2);
  static constexpr size_t kMaxMessages = 64;  // of one read()

  bool send(std::span<const std::byte> message, int descriptor = -1);
  bool share(const std::shared_ptr<isolate::SharedBlock>& block);
  bool forget_gone_blocks();
  std::optional<std::string> release(uint64_t number, Garbage* garbage);

  Descriptor socket_;
  State state_ = State::Greeting;
  bool full_ = false;
  const std::chrono::steady_clock::time_point greeting_ends_ =
      std::chrono::steady_clock::now() + kGreetingTime;
  isolate::MessageWriter writer_;
  std::shared_ptr<const std::string> caps_;                         // sent last
  uint64_t last_number_ = 0;                                        // of the frame sent last
  std::map<uint64_t, std::shared_ptr<const void>> held_;            // by number of the frame
  std::map<uint64_t, std::weak_ptr<isolate::SharedBlock>> blocks_;  // that it knows, by id
};

}  // namespace weir::local
