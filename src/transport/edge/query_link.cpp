// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/query_link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/text/text.hpp"
#include "core/wire/edge_metadata.hpp"
#include "core/wire/peer_error.hpp"
#include "machine/loopback.hpp"
#include "transport/accept_pause.hpp"

namespace weir::edge {
namespace {

constexpr char kNumberKey[] = "weir.seq";
constexpr char kClientKey[] = "client_id";
constexpr char kHostFix[] = "set host to an address of this machine that the server can reach";

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
      .needed =
          "a tensor_query_serversrc that listens at this address, in a pipeline that is playing",
      .fix = std::move(fix)};
}

// The parts of a request that have not been sent.
class UnsentParts {
 public:
  explicit UnsentParts(const RequestMessage& request) {
    parts_.reserve(request.memories.size() + 2);
    add(request.header);
    for (const auto& memory : request.memories) add(memory);
    add(request.metadata);
  }
  bool empty() const { return first_ == parts_.size(); }
  // Sends what the socket takes. Returns the number of bytes, 0 if there is no room now, and -1 if
  // the connection is broken.
  ssize_t send(int socket) {
    msghdr head{};
    head.msg_iov = parts_.data() + first_;
    head.msg_iovlen = parts_.size() - first_;
    ssize_t sent = -1;
    do {
      sent = sendmsg(socket, &head, MSG_NOSIGNAL | MSG_DONTWAIT);
    } while (sent < 0 && errno == EINTR);
    if (sent < 0) return errno == EAGAIN || errno == EWOULDBLOCK ? 0 : -1;
    drop(static_cast<size_t>(sent));
    return sent;
  }

 private:
  void add(std::span<const std::byte> bytes) {
    parts_.push_back({const_cast<std::byte*>(bytes.data()), bytes.size()});
  }
  void drop(size_t count) {
    while (count > 0) {
      iovec& part = parts_[first_];
      const size_t step = std::min(count, part.iov_len);
      part = {static_cast<std::byte*>(part.iov_base) + step, part.iov_len - step};
      count -= step;
      if (part.iov_len == 0) ++first_;
    }
  }

  std::vector<iovec> parts_;
  size_t first_ = 0;
};

Error cancelled() {
  return Error{.code = Code::CANCELLED, .what = "connecting to the server was cancelled"};
}

}  // namespace

QueryLink::QueryLink(const QueryOptions& options) : options_(options) {}

QueryLink::~QueryLink() {
  const bool may_send = requests_ && requests_->form() && !end_ && !is_within_message_;
  if (!may_send) return;
  const auto message = wire::error_message(*requests_->form());
  ::send(requests_->socket(), message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

Result<std::unique_ptr<QueryLink>> QueryLink::connect(const QueryOptions& options) {
  std::unique_ptr<QueryLink> out(new QueryLink(options));
  auto listener = listen_on(options.host, options.port);
  if (!listener) return listener.error();
  out->listener_ = *std::move(listener);
  const auto deadline = io::deadline_in(options.handshake_time);
  auto socket = connect_to(options.server_host, options.server_port, deadline, options.cancel);
  if (!socket && socket.error().code == Code::SERVER_UNREACHABLE) {
    Error error = socket.error();
    error.what = "the query server cannot be reached";
    error.needed =
        "a tensor_query_serversrc that listens at this address, in a pipeline that is playing";
    error.fix = "tensor_query_client reconnect=true, which waits for the tensor_query_serversrc";
    return error;
  }
  if (!socket) return socket.error();
  const wire::MessageLimits texts{.message_bytes = 2 * wire::MessageLimits().text_bytes};
  out->requests_ =
      std::make_unique<MessageConnection>(*std::move(socket), wire::Side::ClientOnA, texts);
  if (auto status = out->read_greeting(deadline); !status) return status.error();
  return out;
}

Result<wire::EdgeMessage> QueryLink::wait_for_greeting(const io::Deadline& deadline) {
  auto step = requests_->wait(deadline, options_.cancel);
  if (!step) return step.error();
  if (step->read == Read::Cancelled) return cancelled();
  if (step->read == Read::Late)
    return unreachable(options_, "the query server does not start the handshake",
                       "nothing within " + seconds_text(options_.handshake_time),
                       "check the port, and that the pipeline of the server is playing");
  if (step->read == Read::Closed)
    return Error{.code = Code::SERVER_REFUSED,
                 .what = "the query server closed the connection before the handshake",
                 .offered = options_.server_host + ":" + std::to_string(options_.server_port),
                 .needed =
                     "a tensor_query_serversrc that accepts another client "
                     "(max-connections)"};
  if (step->action != wire::Action::ReadCapability)
    return wire::peer_error("the query server does not start the handshake",
                            wire::to_string(step->message.command), "CAPABILITY");
  return std::move(step->message);
}

Status QueryLink::read_greeting(const io::Deadline& deadline) {
  const auto message = wait_for_greeting(deadline);
  if (!message) return message.error();
  const auto text = wire::text_of_memory(message->memories.at(0).bytes());
  if (!text) return text.error();
  auto capability = wire::parse_query_capability(*text);
  if (!capability) return capability.error();
  capability_ = *std::move(capability);
  client_id_ = message->client_id;
  return ok();
}

// Returns the address as the server sees it, which cannot connect to "any address".
wire::HostAddress QueryLink::listener_address() const {
  const bool is_any = options_.host.empty() || options_.host == "0.0.0.0";
  return {is_any ? own_address(requests_->socket()) : options_.host, get_port(listener_.get())};
}

Status QueryLink::send_host_info() {
  const auto message = wire::text_message(*requests_->form(), wire::Command::HostInfo, client_id_,
                                          listener_address().to_string());
  if (!message) return message.error();
  // Nothing else was sent on this connection: its buffer has room.
  const ssize_t sent = ::send(requests_->socket(), message->data(), message->size(), MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(message->size())) return ok();
  end(LinkEnd::Lost);
  return unreachable(options_, "the query server closed the connection in the handshake",
                     "it does not accept the address of the client", "look at the server's log");
}

// From the address that the client connected to. A server of this machine that is reached under
// another address than the loopback one may use that.
bool QueryLink::is_of_server(int socket) const {
  const std::string server = get_peer(requests_->socket()), peer = get_peer(socket);
  const bool is_here = own_address(requests_->socket()) == server;
  return peer == server || (is_here && is_loopback(peer) && !is_loopback(server));
}

Status QueryLink::confirm(const io::Deadline& deadline) {
  if (auto status = send_host_info(); !status) return status;
  Pause pause;
  for (;;) {
    const auto accepted = accept_server(deadline, &pause);
    if (!accepted) return accepted.error();
    if (*accepted) break;
  }
  listener_ = Descriptor();
  return ok();
}

Result<bool> QueryLink::accept_server(const io::Deadline& deadline, Pause* pause) {
  const bool is_paused = pause->until && !io::is_over(pause->until);
  pollfd watched[] = {{requests_->socket(), POLLIN, 0},
                      {options_.cancel, POLLIN, 0},
                      {is_paused ? -1 : listener_.get(), POLLIN, 0}};
  const auto next = is_paused ? io::earlier(deadline, pause->until) : deadline;
  const int ready = poll(watched, 3, io::poll_timeout(next));
  if (ready > 0 && watched[1].revents) return cancelled();
  if (ready > 0 && watched[2].revents) accept_waiting(pause);
  if (responses_) return true;
  if (ready > 0 && watched[0].revents)
    if (auto status = check_handshake(); !status) return status.error();
  if (!io::is_over(deadline)) return false;
  return not_connected(*pause);
}

void QueryLink::accept_waiting(Pause* pause) {
  *pause = {};
  errno = 0;
  Descriptor socket = accept_from(listener_.get());
  const int reason = errno;
  if (!socket && transport::is_out_of_resources(reason))
    *pause = {io::deadline_in(transport::kAcceptPause), reason};
  if (socket && is_of_server(socket.get()))
    responses_ = std::make_unique<MessageConnection>(std::move(socket), wire::Side::ClientOnB,
                                                     options_.limits, requests_->form());
}

Error QueryLink::not_connected(const Pause& pause) const {
  const std::string reason = "no connection to " + listener_address().to_string() + " in time";
  if (pause.reason != 0)
    return unreachable(options_, "the connection of the query server cannot be accepted",
                       reason + ": " + std::strerror(pause.reason), transport::kOutOfResourcesFix);
  return unreachable(
      options_,
      "the query server did not connect to the client, which it must do to send its answers",
      reason, kHostFix);
}

// Whether the server has given up instead of connecting.
Status QueryLink::check_handshake() {
  const auto ended = read_ready(true, false);
  if (!ended) return ended.error();
  if (!*ended) return ok();
  return Error{
      .code = Code::SERVER_REFUSED,
      .what = "the query server ended the handshake early",
      .offered = "the client asked it to send its answers to " + listener_address().to_string(),
      .needed = "a server that can connect to this address",
      .fix = kHostFix};
}

Result<RequestMessage> QueryLink::make_request(std::vector<std::span<const std::byte>> memories,
                                               uint64_t number) const {
  wire::EdgeMetadata metadata;
  if (auto status = metadata.set(kNumberKey, std::to_string(number)); !status)
    return status.error();
  if (auto status = metadata.set(kClientKey, std::to_string(client_id_)); !status)
    return status.error();
  RequestMessage out{{}, metadata.encode(), std::move(memories)};
  wire::EdgeHeader header{.command = wire::Command::TransferData,
                          .client_id = client_id_,
                          .metadata_bytes = out.metadata.size()};
  for (const auto& memory : out.memories) header.sizes.push_back(memory.size());
  auto bytes = wire::write_header(*requests_->form(), header);
  if (!bytes) return bytes.error();
  out.header = *std::move(bytes);
  return out;
}

Result<std::optional<LinkEnd>> QueryLink::send(const RequestMessage& request) {
  UnsentParts unsent(request);
  ++sent_;
  late_bytes_ = 0;
  auto deadline = io::deadline_in(options_.stall_time);
  while (!end_ && !unsent.empty()) {
    const ssize_t sent = unsent.send(requests_->socket());
    if (sent > 0) {
      deadline = io::deadline_in(options_.stall_time);
      is_within_message_ = !unsent.empty();
      continue;
    }
    if (sent < 0) return end(LinkEnd::Lost);
    auto ended = wait(deadline, true);
    if (!ended || *ended == LinkEnd::Interrupted) return ended;
    if (*ended == LinkEnd::Late) return end(LinkEnd::Lost);
  }
  return end_;
}

Result<std::optional<LinkEnd>> QueryLink::wait(const io::Deadline& deadline, bool for_room) {
  const auto events = static_cast<short>(for_room ? POLLIN | POLLOUT : POLLIN);
  pollfd watched[] = {{requests_->socket(), events, 0},
                      {options_.cancel, POLLIN, 0},
                      {responses_->socket(), POLLIN, 0}};
  const int ready = poll(watched, 3, io::poll_timeout(deadline));
  if (ready < 0 && errno != EINTR) return end(LinkEnd::Lost);
  if (ready > 0 && watched[1].revents) return End(LinkEnd::Interrupted);
  if (ready == 0 && io::is_over(deadline)) return End(LinkEnd::Late);
  if (ready <= 0) return End();
  auto ended = read_ready((watched[0].revents & ~POLLOUT) != 0, watched[2].revents != 0);
  if (!ended || *ended) return ended;
  if ((watched[0].revents & POLLOUT) || !io::is_over(deadline)) return End();
  // Responses that are there are taken, but messages that mean nothing do not hold up the time.
  late_bytes_ += MessageConnection::kTurnBytes;
  return late_bytes_ > expected_bytes() ? End(LinkEnd::Late) : End();
}

size_t QueryLink::expected_bytes() const noexcept {
  constexpr uint64_t kMaxMessageBytes = uint64_t{1} << 40;
  const uint64_t each = std::min(options_.limits.message_bytes, kMaxMessageBytes);
  return static_cast<size_t>((sent_ - answered_ + 1) * (each + MessageConnection::kTurnBytes));
}

// Responses that came before the end are not lost, and the end of one connection may come before
// the ERROR on the other.
Result<std::optional<LinkEnd>> QueryLink::read_ready(bool has_requests, bool has_responses) {
  Result<End> responses =
      has_responses ? read_side(responses_.get(), false, MessageConnection::kTurnBytes) : End();
  if (!responses) return responses;
  Result<End> requests = has_requests || *responses
                             ? read_side(requests_.get(), true, MessageConnection::kTurnBytes)
                             : Result<End>(End());
  if (!requests) return requests;
  if (*requests && !*responses && responses_)
    responses = read_side(responses_.get(), true, expected_bytes());
  if (!responses) return responses;
  if (!*responses && !*requests) return End();
  const bool refused = *responses == LinkEnd::Refused || *requests == LinkEnd::Refused;
  return end(refused ? LinkEnd::Refused : LinkEnd::Lost);
}

// Reads messages, with `all` until there is nothing more or the bytes of the turn have been read;
// returns how the connection ended, if it did.
Result<std::optional<LinkEnd>> QueryLink::read_side(MessageConnection* from, bool all,
                                                    size_t turn) {
  do {
    auto step = from->read(&turn);
    if (!step) return step.error();
    if (step->read == Read::Nothing) return End();
    if (step->read == Read::Closed) return End(LinkEnd::Lost);
    if (step->action == wire::Action::Close) return End(LinkEnd::Refused);
    if (auto status = take_response(std::move(step->message)); !status) return status.error();
  } while (all || from->has_read_ahead());
  return End();
}

Status QueryLink::take_response(wire::EdgeMessage message) {
  if (answered_ == sent_)
    return wire::peer_error("an answer does not belong to a request", "more answers than requests",
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

Result<QueryLink::Received> QueryLink::receive(const io::Deadline& deadline) {
  late_bytes_ = 0;
  for (;;) {
    if (!arrived_.empty()) {
      Received out{.response = std::move(arrived_.front())};
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
QueryLink::End QueryLink::end(LinkEnd how) noexcept {
  if (!end_) end_ = how;
  return end_;
}

}  // namespace weir::edge
