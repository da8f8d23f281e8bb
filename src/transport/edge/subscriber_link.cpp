// The queue and the handshake of one subscriber.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/subscriber_link.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace weir::edge {
namespace {

constexpr auto kHandshakeTime = std::chrono::seconds(2);
constexpr size_t kMostParts = 64;  // of one call of sendmsg()
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

isolate::Deadline SubscriberLink::patience(const QueueLimits& limits) const {
  if (state_ == State::Greeting) return began_ + kHandshakeTime;
  return full_since_ ? isolate::Deadline(*full_since_ + limits.full_for) : std::nullopt;
}

void SubscriberLink::queue(std::vector<std::byte> header,
                           std::shared_ptr<const SharedMessage> message, uint64_t bytes) {
  std::memcpy(header.data() + wire::layout_of(form_).client_id_offset, &client_id_,
              sizeof client_id_);
  queued_bytes_ += bytes;
  queue_.push_back({std::move(header), std::move(message), bytes});
}

void SubscriberLink::queue_greeting(std::vector<std::byte> message) {
  const size_t bytes = message.size();
  queue(std::move(message), nullptr, bytes);
}

bool SubscriberLink::queue_frame(const std::shared_ptr<const SharedMessage>& message,
                                 const QueueLimits& limits) {
  const bool fits = queue_.size() < limits.frames &&
                    (queue_.empty() || queued_bytes_ + message->bytes <= limits.bytes);
  if (!fits) {
    if (!full_since_) full_since_ = std::chrono::steady_clock::now();
    return false;
  }
  full_since_ = std::nullopt;
  queue(message->header, message, message->bytes);
  return true;
}

void SubscriberLink::drop_sent(size_t count) {
  sent_ += count;
  while (!queue_.empty() && sent_ >= queue_.front().bytes) {
    sent_ -= queue_.front().bytes;
    queued_bytes_ -= queue_.front().bytes;
    queue_.pop_front();
    full_since_ = std::nullopt;
  }
}

void SubscriberLink::send() {
  while (state_ != State::Gone && !queue_.empty()) {
    iovec parts[kMostParts];
    size_t used = 0, skip = sent_;
    const auto add = [&](std::span<const std::byte> bytes) {
      const size_t skipped = std::min(skip, bytes.size());
      skip -= skipped;
      if (skipped < bytes.size() && used < kMostParts)
        parts[used++] = {const_cast<std::byte*>(bytes.data()) + skipped, bytes.size() - skipped};
    };
    add(queue_.front().header);
    if (const auto& message = queue_.front().message)
      for (const auto& memory : message->memories) add(memory);
    msghdr head{};
    head.msg_iov = parts;
    head.msg_iovlen = used;
    const ssize_t sent = sendmsg(socket_.get(), &head, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0) {
      drop_sent(static_cast<size_t>(sent));
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) state_ = State::Gone;
    return;
  }
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
  if (reader_.form() != form_)
    return "it uses headers of " + std::to_string(wire::layout_of(*reader_.form()).bytes) +
           " bytes, not of " + std::to_string(wire::layout_of(form_).bytes) +
           " (property wire-version)";
  state_ = State::Subscribed;
  return std::nullopt;
}

void SubscriberLink::send_error() noexcept {
  if (state_ != State::Subscribed || sent_ > 0)
    return;  // within a message it would be a part of it
  const auto message = wire::error_message(form_);
  ::send(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

}  // namespace weir::edge
