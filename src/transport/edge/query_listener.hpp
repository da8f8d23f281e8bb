// QueryListener: the server of a query in NNStreamer's protocol over TCP
// (docs/compatibility/edge-wire.md 10.1, 10.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "transport/edge/request.hpp"
#include "transport/edge/served_client.hpp"
#include "transport/edge/stream_socket.hpp"
#include "transport/poll_server.hpp"

namespace weir::edge {

struct ListenerOptions {
  std::string host{};
  uint32_t port = 0;  // 0 = a free one
  ClientOptions client{};
  // Requests of one client, and bytes of the requests of one address, that are in progress: then
  // its sockets are not read until one ends. 0 = no limit.
  uint32_t max_requests = 8;
  uint64_t max_address_bytes = uint64_t{256} << 20;
  // Connected clients; 0 = no limit. Those of this machine count for the first one only. A client
  // that is silent for `client.timeout` makes room for one that comes.
  uint32_t max_clients = 32, max_per_address = 4;
  std::function<bool(const std::string& address)> allowed{};  // empty: every address
  std::function<void(const Error&)>
      refused{};  // called for each client that is refused; any thread
};

struct ListenerCounts {
  uint32_t clients = 0;          // whose handshake is complete
  uint64_t clients_refused = 0;  // closed because of what they are, sent, or did not do
  uint64_t answers_lost = 0;     // their client had left, or did not read
  uint32_t requests_waiting = 0;
};

// Thread-safe. A client that does not read or write stalls no other.
class QueryListener : public transport::PollServer<ServedClient> {
 public:
  // Listens. Clients connect, and wait until set_accepting(true). Errors: those of listen_on().
  static Result<std::unique_ptr<QueryListener>> open(ListenerOptions options);
  ~QueryListener() override;

  uint16_t port() const noexcept { return port_; }
  // The caps that clients are greeted with, when both are known: of requests and of responses.
  // OPTION_VALUE, LIMIT_EXCEEDED: no text of the protocol.
  Status set_request_caps(const std::string& caps);
  Status set_response_caps(const std::string& caps);
  // The same until set_response_caps(), and nothing after it.
  Status expect_response_caps(const std::string& caps);
  // False: closes all clients.
  void set_accepting(bool accepting);
  // Accepts no client and reads no request any more; responses are still sent.
  void close();

  // Waits for a request. Null after interrupt(), until resume().
  std::shared_ptr<Request> take();

  enum class Sent {
    Queued,
    NoClient,  // it has left, or cannot be sent such a frame and was refused
    Full
  };
  // Sends a frame to a client. `owner` keeps the memories until it has been sent. `sequence`: of
  // the request that it answers, may be "".
  Sent respond(int64_t client, const std::vector<std::span<const std::byte>>& memories,
               std::shared_ptr<const void> owner, const std::string& sequence);
  // Closes a client because of what it sent.
  void refuse(int64_t client, const std::string& reason);
  // Waits until all responses have been sent; false after the deadline.
  bool flush(const io::Deadline& deadline);
  // Closes all clients and no longer listens. Only counts() and requests() are of use then.
  void stop();

  ListenerCounts counts() const;
  const RequestCounters& requests() const noexcept { return *requests_; }

 private:
  explicit QueryListener(ListenerOptions options)
      : PollServer(options.refused), options_(std::move(options)) {}
  // `is_expected`: keeps caps that are known.
  Status set_caps(std::string* caps, const std::string& value, bool is_expected = false);
  int listening() const override { return accepting_ && !closed_ ? listener_.get() : -1; }
  Descriptor accept() override { return accept_from(listener_.get()); }
  void add(Descriptor socket) override;
  io::Deadline watch(const Clients& clients, std::vector<pollfd>* watched) override;
  void attend(const Client& client, const pollfd* events, ServedClient::Input input) override;
  void end_turn() override;
  bool may_read(const Client& client, bool many_bytes) const;
  // How many clients have a place, and whether all places are taken: of this address, "" = of all.
  uint32_t count(const std::string& address) const;
  bool is_full(const std::string& address) const;
  void make_room(const std::string& address);
  Client silent_client(const std::string& address) const;
  std::string reason_to_refuse(const std::string& address) const;
  void refuse(const Client& client, const std::string& reason);
  void greet(const Client& client);
  Client find(int64_t id) const;

  const ListenerOptions options_;
  Descriptor listener_;
  uint16_t port_ = 0;
  const std::shared_ptr<RequestCounters> requests_ = std::make_shared<RequestCounters>();
  // Guarded by the mutex.
  std::deque<std::shared_ptr<Request>> waiting_;
  std::string request_caps_, response_caps_, capability_;
  uint64_t answers_lost_ = 0;
  bool accepting_ = false, closed_ = false;
};

}  // namespace weir::edge
