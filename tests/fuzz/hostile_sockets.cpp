// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hostile_sockets.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <utility>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::fuzz {
namespace {

using io::Descriptor;

// Honest peers have 127.0.0.1: limits for each address do not concern them.
constexpr char kOwnAddress[] = "127.0.0.2", kServerAddress[] = "127.0.0.1";
constexpr size_t kMaxReceived = 8192;

sockaddr_in to_socket_address(const char* host, uint16_t port) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(port);
  inet_pton(AF_INET, host, &out.sin_addr);
  return out;
}

// The first message of a connection, if it is there.
std::optional<wire::EdgeMessage> first_message(const Bytes& received) {
  wire::EdgeMessageReader reader({}, wire::HeaderForm::Bytes2088);
  if (!reader.feed(received) || !reader.complete()) return std::nullopt;
  return reader.take();
}

}  // namespace

HostilePeer::HostilePeer(Victim victim) : victim_(std::move(victim)) {
  if (victim_.protocol == Protocol::Local) {
    if (victim_.is_server) return;
    auto listener = local::Listener::open(victim_.path);
    require(listener.has_value(), "the path can be listened on");
    local_listener_ = *std::move(listener);
    return;
  }
  auto listener = edge::listen_on(victim_.is_server ? kOwnAddress : kServerAddress, 0);
  require(listener.has_value(), "a port can be listened on");
  listener_ = *std::move(listener);
}

uint16_t HostilePeer::port() const {
  return edge::get_port(listener_.get());
}

void HostilePeer::play(FuzzInput* input) {
  end_ = Clock::now() + kMaxTime;
  while (!input->empty() && Clock::now() < end_) act(input);
}

void HostilePeer::leave() {
  stopping_ = true;
  for (auto& flood : floods_) flood.join();
  floods_.clear();
  connections_.clear();
  listener_ = Descriptor();
  local_listener_.reset();
}

// False at the end of the time.
bool HostilePeer::wait(int socket, short events, int milliseconds) const {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now()).count();
  pollfd watched{socket, events, 0};
  return poll(&watched, 1, static_cast<int>(std::clamp<int64_t>(left, 0, milliseconds))) > 0;
}

void HostilePeer::act(FuzzInput* input) {
  const uint32_t action = input->below(14);
  Connection* connection = action < 2 ? connect() : choose(input);
  if (!connection) return;
  switch (action) {
    case 0:
      return;
    case 1:
      return begin(connection);
    case 2:
    case 3:
      return say(connection, input->byte());
    case 4:
      return say_changed(connection, input);
    case 5: {
      const auto bytes = input->bytes(input->byte());
      return send(*connection, {{bytes.begin(), bytes.end()}});
    }
    case 6: {  // a part of a message
      auto message = make_message(victim_.protocol, input->byte(), &connection->conversation);
      message.bytes.resize(message.bytes.size() * input->byte() / 256);
      return send(*connection, message);
    }
    case 7:
      shutdown(connection->socket.get(), input->flag() ? SHUT_WR : SHUT_RD);
      return;
    case 8:
      return close(connection, input->flag());
    case 9:
      return flood(connection, input->byte());
    case 10:
      return read(connection, size_t{1} << 16);
    case 11:
      wait(-1, 0, static_cast<int>(input->below(32)));
      return;
    case 12:
      return come_and_go(input->below(16));
    default:
      for (uint32_t kind = input->byte(), i = input->byte(); i > 0 && Clock::now() < end_; --i)
        say(connection, kind);
  }
}

HostilePeer::Connection* HostilePeer::choose(FuzzInput* input) {
  if (connections_.empty()) return connect();
  return connections_[input->below(static_cast<uint32_t>(connections_.size()))].get();
}

HostilePeer::Connection* HostilePeer::add(Descriptor socket) {
  if (!socket) return nullptr;
  if (connections_.size() >= kMaxConnections) connections_.erase(connections_.begin());
  auto added = std::make_unique<Connection>();
  added->socket = std::move(socket);
  added->conversation.is_client = victim_.is_server;
  added->conversation.listener = listener_ ? port() : 0;
  return connections_.emplace_back(std::move(added)).get();
}

HostilePeer::Connection* HostilePeer::connect() {
  if (!victim_.is_server) {
    const int listening = local_listener_ ? local_listener_->get() : listener_.get();
    return wait(listening, POLLIN, 50) ? add(accept()) : nullptr;
  }
  if (victim_.protocol != Protocol::Local) return add(connect_to(kOwnAddress, victim_.port));
  auto socket = local::connect_to(victim_.path);
  return socket ? add(*std::move(socket)) : nullptr;
}

Descriptor HostilePeer::connect_to(const char* own_address, uint16_t port) const {
  Descriptor out(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const auto own = to_socket_address(own_address, 0);
  const auto other = to_socket_address(kServerAddress, port);
  if (bind(out.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) return {};
  const int result = ::connect(out.get(), reinterpret_cast<const sockaddr*>(&other), sizeof other);
  return result == 0 || errno == EINPROGRESS ? std::move(out) : Descriptor();
}

Descriptor HostilePeer::accept() const {
  return local_listener_ ? local_listener_->accept() : edge::accept_from(listener_.get());
}

// Does what a good peer does before the first frame.
void HostilePeer::begin(Connection* connection) {
  if (victim_.protocol == Protocol::Stream || victim_.protocol == Protocol::Query)
    return begin_edge(connection);
  if (victim_.protocol == Protocol::Mqtt) return begin_mqtt(connection);
  say(connection, kGreeting);
  if (victim_.protocol != Protocol::Local || victim_.is_server) return;
  say(connection, kCaps);
  say(connection, kMemory);
}

void HostilePeer::begin_edge(Connection* connection) {
  const size_t header = wire::kMaxHeaderBytes;
  if (!victim_.is_server) {
    say(connection, kGreeting);
    read(connection, header + 1);
    return connect_back(*connection);
  }
  read(connection, header + 1);
  if (const auto greeting = first_message(connection->received))
    connection->conversation.client_id = greeting->client_id;
  say(connection, kHostInfo);
  if (wait(listener_.get(), POLLIN, 20)) add(edge::accept_from(listener_.get()));
}

// To the listener of a query client; the receiver of a stream has none.
void HostilePeer::connect_back(const Connection& connection) {
  const auto info = first_message(connection.received);
  if (!info || info->memories.size() != 1) return;
  const auto text = wire::text_of_memory(info->memories[0].bytes());
  if (!text) return;
  const auto address = wire::parse_host_address(*text);
  if (address) add(connect_to(kServerAddress, address->port));
}

void HostilePeer::begin_mqtt(Connection* connection) const {
  constexpr size_t kLevel = 8;  // of CONNECT
  read(connection, kLevel + 1);
  const auto& received = connection->received;
  connection->conversation.is_mqtt5 = received.size() > kLevel && received[kLevel] == std::byte{5};
  say(connection, kGreeting);
  wait(connection->socket.get(), POLLIN, 20);
  say(connection, kSubscribed);
}

// Waits until so many bytes have come, but not for long.
void HostilePeer::read(Connection* connection, size_t wanted) const {
  std::vector<std::byte> buffer(size_t{1} << 16);
  for (size_t sum = 0; sum < wanted;) {
    if (!wait(connection->socket.get(), POLLIN, 20)) return;
    const ssize_t got = recv(connection->socket.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got <= 0) return;
    sum += static_cast<size_t>(got);
    auto& received = connection->received;
    const size_t kept = std::min<size_t>(static_cast<size_t>(got), kMaxReceived - received.size());
    received.insert(received.end(), buffer.begin(),
                    buffer.begin() + static_cast<std::ptrdiff_t>(kept));
  }
}

// Sends what the socket takes.
void HostilePeer::send(const Connection& connection, const HostileMessage& message) {
  const int socket = connection.socket.get();
  if (message.has_memory)
    (void)local::send_packet(socket, message.bytes, hostile_memory());
  else
    (void)::send(socket, message.bytes.data(), message.bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void HostilePeer::say(Connection* connection, uint32_t kind) const {
  send(*connection, make_message(victim_.protocol, kind, &connection->conversation));
}

void HostilePeer::say_changed(Connection* connection, FuzzInput* input) const {
  auto message = make_message(victim_.protocol, input->byte(), &connection->conversation);
  for (uint32_t i = 1 + input->below(4); i > 0 && !message.bytes.empty(); --i) {
    const size_t place = input->take<uint16_t>() % message.bytes.size();
    message.bytes[place] = static_cast<std::byte>(input->byte());
  }
  send(*connection, message);
}

void HostilePeer::flood(Connection* connection, uint32_t kind) {
  if (floods_.size() >= kMaxFloods) return;
  // The connection may be closed meanwhile.
  Descriptor socket(fcntl(connection->socket.get(), F_DUPFD_CLOEXEC, 0));
  floods_.emplace_back(&HostilePeer::run_flood, this, std::move(socket), connection->conversation,
                       kind);
}

void HostilePeer::run_flood(Descriptor socket, Conversation conversation, uint32_t kind) const {
  // The break leaves others a core: 20,000 messages in a second are a flood too.
  for (; !stopping_; std::this_thread::sleep_for(std::chrono::microseconds(50))) {
    const auto message = make_message(victim_.protocol, kind, &conversation);
    for (size_t sent = 0; sent < message.bytes.size() && !stopping_;) {
      pollfd watched{socket.get(), POLLOUT, 0};
      if (poll(&watched, 1, 10) == 0) continue;
      const ssize_t step = ::send(socket.get(), message.bytes.data() + sent,
                                  message.bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (step < 0 && errno != EAGAIN) return;
      if (step > 0) sent += static_cast<size_t>(step);
    }
  }
}

void HostilePeer::close(const Connection* connection, bool with_reset) {
  const linger reset{1, 0};
  if (with_reset) setsockopt(connection->socket.get(), SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
  std::erase_if(connections_, [&](const auto& each) { return each.get() == connection; });
}

void HostilePeer::come_and_go(uint32_t times) {
  for (; times > 0; --times)
    if (const auto* connection = connect()) close(connection, times % 2 == 0);
}

}  // namespace weir::fuzz
