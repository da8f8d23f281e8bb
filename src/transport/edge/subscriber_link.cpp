// The queue and the handshake of one subscriber.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/subscriber_link.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace weir::edge {
namespace {

constexpr auto kLinkHandshakeTime = std::chrono::seconds(2);
// A subscriber sends a short text and no frames.
constexpr wire::MessageLimits kLimits{
    .message_bytes = 4096, .text_bytes = 1024, .metadata_bytes = 1024};

}  // namespace

SubscriberLink::SubscriberLink(Descriptor socket, wire::HeaderForm form, int64_t client_id)
    : socket_(std::move(socket)),
      form_(form),
      client_id_(client_id),
      address_(peer_of(socket_.get())),
      reader_(kLimits) {}

io::Deadline SubscriberLink::patience(const QueueLimits& limits) const {
  if (state_ == State::Waiting) return std::nullopt;
  if (state_ == State::Greeting) return greeted_ + kLinkHandshakeTime;
  const auto& full_since = frames_.full_since();
  return full_since ? io::Deadline(*full_since + limits.full_for) : std::nullopt;
}

void SubscriberLink::set_client_id(std::vector<std::byte>* header) const {
  std::memcpy(header->data() + wire::layout_of(form_).client_id_offset, &client_id_,
              sizeof client_id_);
}

void SubscriberLink::queue_greeting(std::vector<std::byte> message) {
  set_client_id(&message);
  greeting_.push(std::move(message));
  state_ = State::Greeting;
  greeted_ = std::chrono::steady_clock::now();
}

bool SubscriberLink::queue_frame(const std::shared_ptr<const SharedMessage>& message,
                                 const QueueLimits& limits) {
  auto header = message->header;
  set_client_id(&header);
  if (frames_.empty()) is_behind_ = false;
  has_fallen_behind_ = false;
  if (frames_.push(std::move(header), message, limits)) return true;
  ++missed_;
  has_fallen_behind_ = !std::exchange(is_behind_, true);
  return false;
}

void SubscriberLink::send() {
  if (state_ == State::Gone) return;
  if (!greeting_.send(socket_.get()) ||
      (state_ == State::Subscribed && greeting_.empty() && !frames_.send(socket_.get())))
    state_ = State::Gone;
}

std::optional<std::string> SubscriberLink::receive() {
  while (state_ != State::Gone) {
    const auto room = reader_.space();
    const ssize_t got = recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return std::nullopt;
    if (got <= 0) {
      state_ = State::Gone;
      return std::nullopt;
    }
    if (const auto status = reader_.received(static_cast<size_t>(got)); !status)
      return status.error().what + ": " + status.error().offered;
    if (!reader_.complete()) continue;
    if (auto reason = handle(reader_.take())) return reason;
  }
  return std::nullopt;
}

std::optional<std::string> SubscriberLink::handle(const wire::EdgeMessage& message) {
  const auto action = conversation_.next(message.command);
  if (!action) return action.error().what + ": " + action.error().offered;
  if (*action == wire::Action::Close) state_ = State::Gone;
  if (*action != wire::Action::ReadHostInfo) return std::nullopt;
  if (state_ == State::Waiting) return "it sent HOST_INFO before the publisher sent CAPABILITY";
  if (reader_.form() != form_)
    return "it uses headers of " + std::to_string(wire::layout_of(*reader_.form()).bytes) +
           " bytes, not of " + std::to_string(wire::layout_of(form_).bytes) +
           " (property wire-version)";
  state_ = State::Subscribed;
  return std::nullopt;
}

void SubscriberLink::send_error() noexcept {
  if (state_ != State::Subscribed || greeting_.is_within_message() || frames_.is_within_message())
    return;  // within a message it would be a part of it
  const auto message = wire::error_message(form_);
  ::send(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

}  // namespace weir::edge
