// QueryLink: the two connections of a query client with its server in NNStreamer's protocol
// (docs/compatibility/edge-wire.md 10.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "transport/edge/message_connection.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::edge {

struct QueryOptions {
  std::string host = "localhost";  // of the listener to which the server connects
  uint32_t port = 0;               // 0 = a free one
  std::string server_host = "localhost";
  uint32_t server_port = 3000;
  wire::MessageLimits limits{};
  int cancel = -1;                                  // borrowed; ends every wait when readable
  std::chrono::milliseconds handshake_time{10000};  // until the server has greeted
  std::chrono::milliseconds stall_time{10000};  // a server that takes no bytes for so long is lost
};

// A frame as it is sent: its memories are borrowed.
struct RequestMessage {
  std::vector<std::byte> header, metadata;
  std::vector<std::span<const std::byte>> memories;
};

struct QueryResponse {
  std::vector<wire::ByteBlock> memories;
  std::optional<uint64_t> number;  // of its request, from servers that repeat it
};

// How waiting for a response or sending ended without one.
enum class LinkEnd {
  Late,         // the deadline passed
  Interrupted,  // by the descriptor `cancel`
  Refused,      // the server ended the connection with ERROR
  Lost,         // the connection broke, or the server takes no bytes
  OutOfStep     // so many responses are missing that only a new connection helps
};

// Used by one thread; it has none of its own. Requests go out on a connection that the client opens
// (A), responses come in on one that the server opens to the client's listener (B). While it sends,
// it reads responses too, so that a server that first writes and then reads does not block.
//
//   auto link = QueryLink::connect(options);
//   if (fits(link->capability())) link->confirm(deadline);
//   auto request = link->make_request(memories, number);
//   link->send(*request);
//   auto response = link->receive(deadline);
class QueryLink {
 public:
  // Listens, connects and reads the server's greeting. OPTION_VALUE, SERVER_UNREACHABLE,
  // SERVER_REFUSED, PEER_MESSAGE_INVALID, CANCELLED.
  static Result<std::unique_ptr<QueryLink>> connect(const QueryOptions& options);
  QueryLink(const QueryLink&) = delete;
  QueryLink& operator=(const QueryLink&) = delete;
  // Sends ERROR, as this protocol ends connections, unless the connection has ended.
  ~QueryLink();

  const wire::QueryCapability& capability() const noexcept { return capability_; }
  // The caps fit: sends the address of the listener and waits until the server has connected.
  // Errors: as of connect().
  Status confirm(const io::Deadline& deadline);

  // LIMIT_EXCEEDED, FRAME_SIZE: the server cannot receive such a frame.
  Result<RequestMessage> make_request(std::vector<std::span<const std::byte>> memories,
                                      uint64_t number) const;
  // Sends a frame. Returns why the connection has ended, if it has. PEER_MESSAGE_INVALID for what
  // the server sent meanwhile.
  Result<std::optional<LinkEnd>> send(const RequestMessage& request);

  struct Received {
    std::optional<QueryResponse> response{};
    std::optional<LinkEnd> end{};  // instead of a response
  };
  // Waits for the next response; a deadline that has passed takes what is there.
  // PEER_MESSAGE_INVALID.
  Result<Received> receive(const io::Deadline& deadline);

 private:
  using Read = MessageConnection::Read;
  using End = std::optional<LinkEnd>;

  explicit QueryLink(const QueryOptions& options);
  Status read_greeting(const io::Deadline& deadline);
  Result<wire::EdgeMessage> wait_for_greeting(const io::Deadline& deadline);
  Status send_host_info();
  wire::HostAddress listener_address() const;
  // When to accept again after there was no descriptor for the server, and why there was none.
  struct Pause {
    io::Deadline until{};
    int reason = 0;
  };
  // True when the server has connected.
  Result<bool> accept_server(const io::Deadline& deadline, Pause* pause);
  void accept_waiting(Pause* pause);
  Error not_connected(const Pause& pause) const;
  bool is_of_server(int socket) const;
  Status check_handshake();
  Result<End> read_ready(bool has_requests, bool has_responses);
  Result<End> read_side(MessageConnection* from, bool all, size_t turn);
  // The bytes that the responses which may still come can have.
  size_t expected_bytes() const noexcept;
  Status take_response(wire::EdgeMessage message);
  // Waits for bytes, and with `for_room` also for room to send, and reads what has arrived.
  Result<End> wait(const io::Deadline& deadline, bool for_room);
  End end(LinkEnd how) noexcept;

  const QueryOptions options_;
  Descriptor listener_;
  std::unique_ptr<MessageConnection> requests_, responses_;  // A and B
  wire::QueryCapability capability_;
  int64_t client_id_ = 0;
  bool is_within_message_ = false;
  uint64_t sent_ = 0, answered_ = 0;
  size_t late_bytes_ = 0;  // that may have been read since the deadline of this call passed
  std::deque<QueryResponse> arrived_;
  std::optional<LinkEnd> end_;
};

}  // namespace weir::edge
