// The handshake of a query client, its requests and their answers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/query_link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "core/text/text.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/peer_error.hpp"
#include "transport/network_policy.hpp"

namespace weir::edge {
namespace {

constexpr auto kSilence = std::chrono::milliseconds(200);
constexpr char kNumberKey[] = "weir.seq";
constexpr char kClientKey[] = "client_id";

bool would_wait() {
  return errno == EAGAIN || errno == EWOULDBLOCK;
}

std::string seconds_text(std::chrono::milliseconds time) {
  return std::to_string(time.count() / 1000) + " s";
}

// The address of this end, as text.
std::string own_address(int socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  char text[INET_ADDRSTRLEN] = "?";
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0)
    inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
  return text;
}

Error unreachable(const QueryOptions& options, std::string what, const std::string& reason,
                  std::string fix) {
  return Error{
      .code = Code::SERVER_UNREACHABLE,
      .what = std::move(what),
      .offered = options.server_host + ":" + std::to_string(options.server_port) + ": " + reason,
      .needed = "a tensor_query_serversrc that listens there and whose pipeline plays",
      .fix = std::move(fix)};
}

Error cancelled() {
  return Error{.code = Code::CANCELLED, .what = "connecting to the server was cancelled"};
}

}  // namespace

QueryLink::QueryLink(const QueryOptions& options) : options_(options) {}

QueryLink::~QueryLink() {
  const bool may_send = requests_ && requests_->reader.form() && !end_ && !is_within_message_;
  if (!may_send) return;
  const auto message = wire::error_message(*requests_->reader.form());
  ::send(requests_->socket.get(), message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

Result<std::unique_ptr<QueryLink>> QueryLink::connect(const QueryOptions& options) {
  std::unique_ptr<QueryLink> out(new QueryLink(options));
  auto listener = listen_on(options.host, options.port);
  if (!listener) return listener.error();
  out->listener_ = *std::move(listener);
  const auto deadline = isolate::deadline_in(options.handshake_time);
  auto socket = connect_to(options.server_host, options.server_port, deadline, options.cancel);
  if (!socket && socket.error().code == Code::SERVER_UNREACHABLE) {
    Error error = socket.error();
    error.what = "the query server cannot be reached";
    error.needed = "a tensor_query_serversrc that listens there and whose pipeline plays";
    return error;
  }
  if (!socket) return socket.error();
  out->requests_ = std::make_unique<Connection>(
      Connection{*std::move(socket),
                 wire::MessageReader({.message_bytes = 2 * wire::MessageLimits().text_bytes}),
                 wire::Conversation(wire::Side::ClientOnA)});
  if (auto status = out->read_greeting(deadline); !status) return status.error();
  return out;
}

Result<QueryLink::Read> QueryLink::read(Connection* from) {
  auto& reader = from->reader;
  for (;;) {
    if (from->ahead_begin < from->ahead_end) {
      const auto bytes =
          std::span(from->ahead).subspan(from->ahead_begin, from->ahead_end - from->ahead_begin);
      const auto taken = reader.feed(bytes);
      if (!taken) return taken.error();
      from->ahead_begin += *taken;
    }
    if (reader.complete()) return Read::Message;
    const auto room = reader.space();
    iovec parts[] = {{room.data(), room.size()}, {from->ahead.data(), from->ahead.size()}};
    msghdr head{};
    head.msg_iov = parts;
    head.msg_iovlen = 2;
    const ssize_t got = recvmsg(from->socket.get(), &head, MSG_DONTWAIT);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && would_wait()) return Read::Nothing;
    if (got <= 0) return Read::Closed;
    bytes_received_ += static_cast<uint64_t>(got);
    const size_t used = std::min(static_cast<size_t>(got), room.size());
    from->ahead_begin = 0;
    from->ahead_end = static_cast<size_t>(got) - used;
    if (auto status = reader.received(used); !status) return status.error();
  }
}

Result<std::optional<LinkEnd>> QueryLink::wait(const isolate::Deadline& deadline, bool for_room) {
  const auto events = static_cast<short>(for_room ? POLLIN | POLLOUT : POLLIN);
  pollfd watched[] = {{requests_->socket.get(), events, 0},
                      {options_.cancel, POLLIN, 0},
                      {answers_ ? answers_->socket.get() : -1, POLLIN, 0}};
  const int ready = poll(watched, 3, isolate::poll_timeout(deadline));
  if (ready < 0 && errno != EINTR) return std::optional(LinkEnd::Lost);
  if (ready > 0 && watched[1].revents) return std::optional(LinkEnd::Interrupted);
  if (ready == 0 && isolate::is_over(deadline)) return std::optional(LinkEnd::Late);
  const bool has_answers = ready > 0 && watched[2].revents != 0,
             has_requests = ready > 0 && (watched[0].revents & ~POLLOUT) != 0;
  if (auto status = read_ready(has_requests, has_answers); !status) return status.error();
  return end_;
}

Result<wire::EdgeMessage> QueryLink::wait_for_greeting(const isolate::Deadline& deadline) {
  for (;;) {
    const auto got = read(requests_.get());
    if (!got) return got.error();
    if (*got == Read::Message) return requests_->reader.take();
    if (*got == Read::Closed)
      return Error{.code = Code::SERVER_REFUSED,
                   .what = "the query server closed the connection without a greeting",
                   .offered = options_.server_host + ":" + std::to_string(options_.server_port),
                   .needed = "a tensor_query_serversrc that has room for another client"};
    // Silence decides the form of some greetings.
    const bool undecided = !requests_->reader.form() && !requests_->reader.at_start();
    const auto until = undecided ? isolate::deadline_in(kSilence) : deadline;
    pollfd watched[] = {{requests_->socket.get(), POLLIN, 0}, {options_.cancel, POLLIN, 0}};
    const int ready = poll(watched, 2, isolate::poll_timeout(until));
    if (ready > 0 && watched[1].revents) return cancelled();
    if (ready == 0 && undecided && isolate::is_over(until))
      if (auto status = requests_->reader.silence(); !status) return status.error();
    if (isolate::is_over(deadline))
      return unreachable(options_, "the query server does not greet",
                         "nothing within " + seconds_text(options_.handshake_time),
                         "check the port, and that its pipeline plays");
  }
}

Status QueryLink::read_greeting(const isolate::Deadline& deadline) {
  const auto message = wait_for_greeting(deadline);
  if (!message) return message.error();
  const auto action = requests_->conversation.next(message->command);
  if (!action) return action.error();
  if (*action != wire::Action::ReadCapability || message->memories.empty())
    return wire::peer_error("the query server does not greet", wire::to_string(message->command),
                            "CAPABILITY");
  const auto text = wire::text_of_memory(message->memories.front().bytes());
  if (!text) return text.error();
  auto capability = wire::parse_query_capability(*text);
  if (!capability) return capability.error();
  capability_ = *std::move(capability);
  client_id_ = message->client_id;
  return ok();
}

// The server cannot connect to "any address".
std::string QueryLink::announced_host() const {
  if (!options_.host.empty() && options_.host != "0.0.0.0") return options_.host;
  return own_address(requests_->socket.get());
}

Status QueryLink::send_host_info() {
  const wire::HostAddress own{announced_host(), port_of(listener_.get())};
  const auto message = wire::text_message(*requests_->reader.form(), wire::Command::HostInfo,
                                          client_id_, own.to_string());
  if (!message) return message.error();
  // Nothing else was sent on this connection: its buffer has room.
  const ssize_t sent =
      ::send(requests_->socket.get(), message->data(), message->size(), MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(message->size())) return ok();
  end(LinkEnd::Lost);
  return unreachable(options_, "the query server closed the connection in the handshake",
                     "it does not take the address of the client", "look at the server's log");
}

// A server of this machine that is reached under another address than the loopback one may use
// that.
bool QueryLink::is_of_server(int socket) const {
  const std::string server = peer_of(requests_->socket.get()), peer = peer_of(socket);
  const bool is_here = own_address(requests_->socket.get()) == server;
  return peer == server ||
         (is_here && transport::is_loopback(peer) && !transport::is_loopback(server));
}

Status QueryLink::confirm(const isolate::Deadline& deadline) {
  if (auto status = send_host_info(); !status) return status;
  auto status = accept_server(deadline);
  listener_ = Descriptor();
  return status;
}

Status QueryLink::accept_server(const isolate::Deadline& deadline) {
  const std::string own = announced_host() + ":" + std::to_string(port_of(listener_.get()));
  const std::string fix = "set host to an address of this machine that the server reaches";
  for (;;) {
    pollfd watched[] = {{requests_->socket.get(), POLLIN, 0},
                        {options_.cancel, POLLIN, 0},
                        {listener_.get(), POLLIN, 0}};
    const int ready = poll(watched, 3, isolate::poll_timeout(deadline));
    if (ready > 0 && watched[1].revents) return cancelled();
    if (ready > 0 && watched[2].revents) {
      Descriptor socket = accept_from(listener_.get());
      if (!socket || !is_of_server(socket.get())) continue;
      answers_ = std::make_unique<Connection>(Connection{
          std::move(socket), wire::MessageReader(options_.limits, *requests_->reader.form()),
          wire::Conversation(wire::Side::ClientOnB)});
      return ok();
    }
    if (ready > 0 && watched[0].revents) {
      if (auto status = read_ready(true, false); !status) return status;
      if (end_)
        return Error{.code = Code::SERVER_REFUSED,
                     .what = "the query server ended the handshake",
                     .offered = "it should connect to " + own + " for its answers",
                     .needed = "a server that can connect to this address",
                     .fix = fix};
    }
    if (isolate::is_over(deadline))
      return unreachable(options_,
                         "the query server does not connect to the client for its answers",
                         "no connection to " + own + " in time", fix);
  }
}

Result<QueryRequest> QueryLink::make_request(std::vector<std::span<const std::byte>> memories,
                                             uint64_t number) const {
  wire::EdgeMetadata metadata;
  if (auto status = metadata.set(kNumberKey, std::to_string(number)); !status)
    return status.error();
  if (auto status = metadata.set(kClientKey, std::to_string(client_id_)); !status)
    return status.error();
  QueryRequest out{{}, metadata.encode(), std::move(memories)};
  wire::EdgeHeader header{.command = wire::Command::TransferData,
                          .client_id = client_id_,
                          .metadata_bytes = out.metadata.size()};
  for (const auto& memory : out.memories) header.sizes.push_back(memory.size());
  auto bytes = wire::write_header(*requests_->reader.form(), header);
  if (!bytes) return bytes.error();
  out.header = *std::move(bytes);
  return out;
}

Result<std::optional<LinkEnd>> QueryLink::send(const QueryRequest& request) {
  std::vector<iovec> parts;
  const auto add = [&](std::span<const std::byte> bytes) {
    parts.push_back({const_cast<std::byte*>(bytes.data()), bytes.size()});
  };
  add(request.header);
  for (const auto& memory : request.memories) add(memory);
  add(request.metadata);
  ++sent_;
  size_t first = 0;
  auto deadline = isolate::deadline_in(options_.stall_time);
  while (!end_ && first < parts.size()) {
    msghdr head{};
    head.msg_iov = parts.data() + first;
    head.msg_iovlen = parts.size() - first;
    const ssize_t sent = sendmsg(requests_->socket.get(), &head, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) {
      bytes_sent_ += static_cast<uint64_t>(sent);
      deadline = isolate::deadline_in(options_.stall_time);
      for (auto left = static_cast<size_t>(sent); left > 0;) {
        const size_t step = std::min(left, parts[first].iov_len);
        parts[first].iov_base = static_cast<std::byte*>(parts[first].iov_base) + step;
        parts[first].iov_len -= step;
        left -= step;
        if (parts[first].iov_len == 0) ++first;
      }
      is_within_message_ = first < parts.size();
      continue;
    }
    if (errno == EINTR) continue;
    if (!would_wait()) {
      end(LinkEnd::Lost);
      break;
    }
    const auto ended = wait(deadline, true);
    if (!ended || *ended == LinkEnd::Interrupted) return ended;
    if (*ended) end(**ended == LinkEnd::Refused ? LinkEnd::Refused : LinkEnd::Lost);
  }
  return end_;
}

// Answers that came before the end are not lost, and the end of one connection may come before the
// ERROR on the other.
Status QueryLink::read_ready(bool has_requests, bool has_answers) {
  using End = Result<std::optional<LinkEnd>>;
  const End none = std::optional<LinkEnd>();
  End answers = has_answers ? read_side(answers_.get(), false) : none;
  if (!answers) return answers.error();
  const End requests = has_requests || *answers ? read_side(requests_.get(), true) : none;
  if (!requests) return requests.error();
  if (*requests && !*answers && answers_) answers = read_side(answers_.get(), true);
  if (!answers) return answers.error();
  if (*answers || *requests)
    end(*answers == LinkEnd::Refused || *requests == LinkEnd::Refused ? LinkEnd::Refused
                                                                      : LinkEnd::Lost);
  return ok();
}

// Reads messages, with `all` until there is nothing more; returns how the connection ended, if it
// did.
Result<std::optional<LinkEnd>> QueryLink::read_side(Connection* from, bool all) {
  do {
    const auto got = read(from);
    if (!got) return got.error();
    if (*got == Read::Nothing) return std::optional<LinkEnd>();
    if (*got == Read::Closed) return std::optional(LinkEnd::Lost);
    auto message = from->reader.take();
    const auto action = from->conversation.next(message.command);
    if (!action) return action.error();
    if (*action == wire::Action::Close) return std::optional(LinkEnd::Refused);
    if (*action == wire::Action::ReadFrame)
      if (auto status = take_answer(std::move(message)); !status) return status.error();
  } while (all || from->ahead_begin < from->ahead_end);
  return std::optional<LinkEnd>();
}

Status QueryLink::take_answer(wire::EdgeMessage message) {
  if (answered_ == sent_)
    return wire::peer_error("an answer belongs to no request", "one answer more than requests",
                            "one answer for each request");
  const auto metadata = wire::EdgeMetadata::parse(message.metadata.bytes());
  if (!metadata) return metadata.error();
  std::optional<uint64_t> number;
  if (const auto text = metadata->find(kNumberKey)) {
    number = parse_unsigned(*text);
    if (!number)
      return wire::peer_error("an answer has no usable weir.seq", wire::quoted_text(*text),
                              "the number of its request");
  }
  ++answered_;
  arrived_.push_back({std::move(message.memories), number});
  return ok();
}

Result<QueryLink::Received> QueryLink::receive(const isolate::Deadline& deadline) {
  for (;;) {
    if (!arrived_.empty()) {
      Received out{.answer = std::move(arrived_.front())};
      arrived_.pop_front();
      return out;
    }
    if (end_) return Received{.end = end_};
    const auto ended = wait(deadline, false);
    if (!ended) return ended.error();
    if (*ended && arrived_.empty()) return Received{.end = *ended};
  }
}

// What arrived before remains.
void QueryLink::end(LinkEnd how) noexcept {
  if (!end_) end_ = how;
}

}  // namespace weir::edge
