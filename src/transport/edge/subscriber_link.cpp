// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/subscriber_link.hpp"

#include <sys/socket.h>

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
    : connection_(std::move(socket), wire::Side::Publisher, kLimits, {}, 0),
      form_(form),
      client_id_(client_id),
      address_(get_peer(connection_.socket())) {}

io::Deadline SubscriberLink::removal_deadline(const QueueLimits& limits) const {
  if (state_ == State::Waiting) return std::nullopt;
  if (state_ == State::Greeting) return greeted_ + kLinkHandshakeTime;
  const auto& full_since = frames_.full_since();
  return full_since ? io::Deadline(*full_since + limits.full_for) : std::nullopt;
}

void SubscriberLink::set_client_id(std::vector<std::byte>* header) const {
  std::memcpy(header->data() + wire::get_layout(form_).client_id_offset, &client_id_,
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
  if (!greeting_.send(connection_.socket()) ||
      (state_ == State::Subscribed && greeting_.empty() && !frames_.send(connection_.socket())))
    state_ = State::Gone;
}

SubscriberLink::Input SubscriberLink::read(const pollfd* events) {
  size_t turn = MessageConnection::kTurnBytes;
  if (!(events->revents & ~POLLOUT)) return MessageConnection::Step{};
  return connection_.read(&turn);
}

std::optional<std::string> SubscriberLink::take(const Input& input) {
  if (!input) return input.error().what + ": " + input.error().offered;
  if (input->read == MessageConnection::Read::Closed || input->action == wire::Action::Close)
    state_ = State::Gone;
  if (input->action != wire::Action::ReadHostInfo) return std::nullopt;
  if (state_ == State::Waiting) return "it sent HOST_INFO before the publisher sent CAPABILITY";
  const auto form = *connection_.form();
  if (form != form_)
    return "it uses headers of " + std::to_string(wire::get_layout(form).bytes) +
           " bytes, not of " + std::to_string(wire::get_layout(form_).bytes) +
           " (property wire-version)";
  state_ = State::Subscribed;
  return std::nullopt;
}

void SubscriberLink::send_error() noexcept {
  if (state_ != State::Subscribed || greeting_.is_within_message() || frames_.is_within_message())
    return;  // within a message it would be a part of it
  const auto message = wire::error_message(form_);
  ::send(connection_.socket(), message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

}  // namespace weir::edge
