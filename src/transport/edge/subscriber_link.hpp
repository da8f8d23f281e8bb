// SubscriberLink: one subscriber as its publisher sees it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "transport/edge/message_connection.hpp"
#include "transport/edge/send_queue.hpp"

namespace weir::edge {

// Used under the publisher's lock, but read(). Nothing here blocks.
class SubscriberLink {
 public:
  enum class State {
    Waiting,   // for the caps that it is greeted with
    Greeting,  // its HOST_INFO has to come
    Subscribed,
    Gone
  };

  // `client_id` is announced to the peer, and part of each frame.
  SubscriberLink(Descriptor socket, wire::HeaderForm form, int64_t client_id);

  static constexpr size_t kSockets = 1;
  int socket() const noexcept { return connection_.socket(); }
  const std::string& address() const noexcept { return address_; }
  State state() const noexcept { return state_; }
  bool is_gone() const noexcept { return state_ == State::Gone; }
  void set_gone() noexcept { state_ = State::Gone; }
  bool has_unsent() const noexcept { return !greeting_.empty() || !frames_.empty(); }
  // Whether the socket should take something now: frames wait for the end of the handshake.
  bool can_send() const noexcept {
    return !greeting_.empty() || (state_ == State::Subscribed && !frames_.empty());
  }
  // Whether frames are queued for it. A subscriber that waited for the caps gets the frames after
  // them, although its handshake is not complete.
  bool gets_frames() const noexcept {
    return state_ == State::Subscribed || (state_ == State::Greeting && has_waited_);
  }
  // When the peer is to be removed unless it greets or reads; nullopt: it need not do anything.
  io::Deadline removal_deadline(const QueueLimits& limits) const;

  // `message`: a CAPABILITY. The time for the handshake begins.
  void queue_greeting(std::vector<std::byte> message);
  // The subscriber waits for queue_greeting(); no time limit applies.
  void wait_for_greeting() noexcept { has_waited_ = true; }
  // False: the queue is full.
  bool queue_frame(const std::shared_ptr<const SharedMessage>& message, const QueueLimits& limits);
  // Whether the last queue_frame() began an outage, which ends when all queued frames are sent.
  bool has_fallen_behind() const noexcept { return has_fallen_behind_; }
  size_t queued_frames() const noexcept { return frames_.size(); }
  // Frames that the queue had no room for.
  uint64_t missed() const noexcept { return missed_; }
  // Sends what the socket takes.
  void send();
  // Reads what arrived. One thread, without the lock.
  using Input = Result<MessageConnection::Step>;
  Input read(const pollfd* events);
  // Handles it; nullopt, or why the subscriber is refused.
  std::optional<std::string> take(const Input& input);
  // Tells the peer that this end closes.
  void send_error() noexcept;

 private:
  void set_client_id(std::vector<std::byte>* header) const;

  MessageConnection connection_;  // only read() reads
  const wire::HeaderForm form_;
  const int64_t client_id_;
  const std::string address_;
  State state_ = State::Waiting;
  bool has_waited_ = false, is_behind_ = false, has_fallen_behind_ = false;
  uint64_t missed_ = 0;
  std::chrono::steady_clock::time_point greeted_;
  SendQueue greeting_, frames_;
};

}  // namespace weir::edge
