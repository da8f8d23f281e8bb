// Recognises the publisher's form, answers its greeting and reads frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/stream_subscriber.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "core/wire/edge_texts.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::edge {
namespace {

constexpr auto kSubscriberSilence = std::chrono::milliseconds(200);

bool would_wait() {
  return errno == EAGAIN || errno == EWOULDBLOCK;
}

Error cancelled_subscription() {
  return Error{.code = Code::CANCELLED, .what = "connecting was cancelled"};
}

Error no_greeting(const char* reason) {
  return Error{.code = Code::SERVER_REFUSED,
               .what = "the edgesink did not start the handshake",
               .offered = reason,
               .needed = "an edgesink that accepts another subscriber"};
}

}  // namespace

Result<StreamSubscriber> StreamSubscriber::open(const std::string& host, uint32_t port,
                                                const wire::MessageLimits& limits,
                                                std::chrono::milliseconds time, int cancel) {
  auto socket = connect_to(host, port, io::deadline_in(time), cancel);
  if (!socket) return socket.error();
  return StreamSubscriber(*std::move(socket), limits);
}

Result<StreamSubscriber> StreamSubscriber::connect(const std::string& host, uint32_t port,
                                                   const wire::MessageLimits& limits, int cancel) {
  return connect(host, port, limits, Times(), cancel);
}

Result<StreamSubscriber> StreamSubscriber::connect(const std::string& host, uint32_t port,
                                                   const wire::MessageLimits& limits,
                                                   const Times& times, int cancel) {
  auto out = open(host, port, limits, times.connect, cancel);
  if (!out) return out;
  const auto greeted = out->greet(io::deadline_in(times.greet), cancel);
  if (!greeted) return greeted.error();
  if (!*greeted) return no_greeting("nothing in time");
  return out;
}

Result<std::optional<StreamSubscriber::Wait>> StreamSubscriber::read_some() {
  while (!reader_->complete()) {
    const auto room = reader_->space();
    ssize_t got = -1;
    do {
      got = recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
    } while (got < 0 && errno == EINTR);
    if (got < 0) return would_wait() ? std::optional<Wait>() : std::optional(Wait::Closed);
    if (got == 0) return std::optional(Wait::Closed);
    if (auto status = reader_->received(static_cast<size_t>(got)); !status) return status.error();
  }
  return std::optional(Wait::Message);
}

std::optional<StreamSubscriber::Wait> StreamSubscriber::wait_for_bytes(const io::Deadline& deadline,
                                                                       int cancel) {
  pollfd watched[] = {{socket_.get(), POLLIN, 0}, {cancel, POLLIN, 0}};
  const int ready = poll(watched, 2, io::poll_timeout(deadline));
  if (ready < 0 && errno != EINTR) return Wait::Closed;
  if (ready > 0 && watched[1].revents) return Wait::Cancelled;
  if (ready == 0 && io::is_over(deadline)) return Wait::Late;
  return std::nullopt;
}

// Silence decides the form of some greetings.
Result<std::optional<StreamSubscriber::Wait>> StreamSubscriber::wait_for_more(
    const io::Deadline& deadline, int cancel) {
  if (reader_->form() || reader_->at_start()) return wait_for_bytes(deadline, cancel);
  const auto ended = wait_for_bytes(io::deadline_in(kSubscriberSilence), cancel);
  if (ended != Wait::Late) return ended;
  if (auto status = reader_->silence(); !status) return status.error();
  return io::is_over(deadline) ? ended : std::nullopt;
}

Result<StreamSubscriber::Wait> StreamSubscriber::wait(const io::Deadline& deadline, int cancel) {
  for (;;) {
    auto ended = read_some();
    if (ended && !*ended) ended = wait_for_more(deadline, cancel);
    if (!ended) return ended.error();
    if (*ended) return **ended;
  }
}

Result<bool> StreamSubscriber::greet(const io::Deadline& deadline, int cancel) {
  const auto waited = wait(deadline, cancel);
  if (!waited) return waited.error();
  if (*waited == Wait::Cancelled) return cancelled_subscription();
  if (*waited == Wait::Late) return false;
  if (*waited == Wait::Closed) return no_greeting("it closed the connection");
  const auto message = reader_->take();
  const auto action = conversation_.next(message.command);
  if (!action) return action.error();
  if (*action == wire::Action::Close) return no_greeting("it has stopped");
  if (*action != wire::Action::ReadCapability || message.memories.empty())
    return wire::peer_error("the edgesink did not start the handshake",
                            wire::to_string(message.command), "CAPABILITY");
  const auto text = wire::text_of_memory(message.memories.front().bytes());
  if (!text) return text.error();
  auto caps = wire::parse_publisher_capability(*text);
  if (!caps) return caps.error();
  caps_ = *std::move(caps);
  if (auto status = send_host_info(message.client_id); !status) return status.error();
  return true;
}

Status StreamSubscriber::send_host_info(int64_t client_id) {
  // The publisher never connects there.
  const wire::HostAddress own{"127.0.0.1", std::max<uint16_t>(port_of(socket_.get()), 1)};
  const auto message =
      wire::text_message(*reader_->form(), wire::Command::HostInfo, client_id, own.to_string());
  if (!message) return message.error();
  // Nothing else was sent on this connection: its buffer has room.
  const ssize_t sent = send(socket_.get(), message->data(), message->size(), MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(message->size())) return ok();
  return Error{.code = Code::SERVER_UNREACHABLE,
               .what = "the edgesink closed the connection in the handshake"};
}

Result<StreamSubscriber::Received> StreamSubscriber::receive(int cancel) {
  for (;;) {
    const auto waited = wait(std::nullopt, cancel);
    if (!waited) return waited.error();
    if (*waited == Wait::Cancelled) return Received{.end = End::Interrupted};
    if (*waited != Wait::Message) return Received{.end = End::Lost};
    auto message = reader_->take();
    const auto action = conversation_.next(message.command);
    if (!action) return action.error();
    if (*action == wire::Action::Close) return Received{.end = End::Lost};
    if (*action == wire::Action::ReadFrame)
      return Received{.memories = std::move(message.memories)};
  }
}

}  // namespace weir::edge
