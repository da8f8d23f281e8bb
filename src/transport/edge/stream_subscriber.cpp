// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/stream_subscriber.hpp"

#include <sys/socket.h>

#include <algorithm>

#include "core/wire/edge_capability.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::edge {
namespace {

using Read = MessageConnection::Read;

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

Result<bool> StreamSubscriber::greet(const io::Deadline& deadline, int cancel) {
  const auto step = connection_->wait(deadline, cancel);
  if (!step) return step.error();
  if (step->read == Read::Cancelled) return cancelled_subscription();
  if (step->read == Read::Late) return false;
  if (step->read == Read::Closed) return no_greeting("it closed the connection");
  const auto& message = step->message;
  if (step->action == wire::Action::Close) return no_greeting("it has stopped");
  if (step->action != wire::Action::ReadCapability || message.memories.empty())
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
  const wire::HostAddress own{"127.0.0.1", std::max<uint16_t>(get_port(connection_->socket()), 1)};
  const auto message =
      wire::text_message(*connection_->form(), wire::Command::HostInfo, client_id, own.to_string());
  if (!message) return message.error();
  // Nothing else was sent on this connection: its buffer has room.
  const ssize_t sent = send(connection_->socket(), message->data(), message->size(), MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(message->size())) return ok();
  return Error{.code = Code::SERVER_UNREACHABLE,
               .what = "the edgesink closed the connection in the handshake"};
}

Result<StreamSubscriber::Received> StreamSubscriber::receive(int cancel) {
  auto step = connection_->wait(std::nullopt, cancel);
  if (!step) return step.error();
  if (step->read == Read::Cancelled) return Received{.end = End::Interrupted};
  if (step->action != wire::Action::ReadFrame) return Received{.end = End::Lost};
  return Received{.memories = std::move(step->message.memories)};
}

}  // namespace weir::edge
