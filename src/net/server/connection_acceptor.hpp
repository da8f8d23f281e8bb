// ConnectionAcceptor: accepts the connections of a gRPC server, limits how many are open, and ends
// those that cost too much. gRPC's own listener has no limits, and ends for ever when the process
// has no descriptor left.
//
//   auto acceptor = ConnectionAcceptor::listen(options);
//   acceptor->start([](int socket) { ... });
//   acceptor->call_began(peer);  // of each call; then message_came(), and call_ended() once
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "machine/descriptor.hpp"
#include "net/server/connection_cost.hpp"
#include "net/server/listener.hpp"

namespace weir::net {

// The calls that gRPC lets a connection have; 0 = no limit.
uint32_t max_streams(const ListenOptions& options);

// 0 = no limit, except of connections.
struct ConnectionLimits {
  uint32_t connections = 256;         // that are open
  uint32_t address_connections = 32;  // of one IPv4 address, or of one network (/64) of IPv6
  uint32_t calls = 64;                // of one connection that have not ended
  uint64_t message_bytes = 64u << 20;
  uint64_t bytes = 256u << 20;  // of the messages that one address sends at a time
  std::chrono::milliseconds first_call{10'000};
};

// Thread-safe.
//
// A connection belongs to gRPC. This has a second descriptor of its socket, through which it sees
// the end of the connection, and ends it: gRPC shuts a socket down before it closes it.
//
// A connection ends when it has received more than its messages explain (ConnectionCost), and when
// a client resets too many calls. Its address must wait then until it may connect again.
class ConnectionAcceptor {
 public:
  // Called with each connection, on a thread of its own: gRPC reads there as long as data come.
  // Owns the descriptor from then on.
  using Connected = std::function<void(int socket)>;

  // Listens on the address of `options`; port 0 uses a free one. OPTION_VALUE.
  static Result<std::unique_ptr<ConnectionAcceptor>> listen(const ListenOptions& options);
  ~ConnectionAcceptor();
  ConnectionAcceptor(const ConnectionAcceptor&) = delete;
  ConnectionAcceptor& operator=(const ConnectionAcceptor&) = delete;

  uint32_t port() const noexcept { return port_; }  // 0 for a Unix socket
  void start(Connected connected);
  // Accepts no more connections. Those that are open remain, unless gRPC takes longer than half a
  // second to take over the last ones.
  void stop();

  // A call of a client, by gRPC's name of it. All clients of a Unix socket have one name.
  void call_began(const std::string& peer);
  void message_came(const std::string& peer);
  void call_ended(const std::string& peer);
  // What the connections of this name have received so far; nullopt if that is unknown, as it is of
  // a Unix socket.
  std::optional<uint64_t> bytes_received(const std::string& peer) const;
  // Connections that were closed because of a limit, or without a descriptor for gRPC.
  uint64_t refused() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    io::Descriptor socket;
    std::string network;
    Clock::time_point accepted;
    bool is_known = false;  // had a call
    bool is_refused = false;
    bool had_message = false;  // or a call, since the last look
    uint32_t calls = 0;        // that have not ended
    ConnectionCost cost;
    // At the last look with one. A call that ends without its message leaves what it received.
    uint32_t calls_then = 0;
  };
  using Connections = std::unordered_multimap<std::string, Connection>;  // by the names of peers

  struct Network {
    uint32_t connections = 0;
    Clock::time_point barred_until;
  };

  explicit ConnectionAcceptor(const ConnectionLimits& limits) : limits_(limits) {}
  bool bind_port(const ListenOptions& options);
  bool bind_path(const ListenOptions& options);
  static std::optional<Traffic> read_traffic(const Connection& connection);
  bool is_costly(Connection* connection, Clock::time_point now) const;
  void refuse(Connection* connection);
  void bar(const std::string& network);
  // The thread's.
  void serve() noexcept;
  bool serve_once();
  void pause() const noexcept;
  int watch(std::vector<pollfd>* watched) const;
  Connections::iterator forget(Connections::iterator at);
  void forget_ended(const std::vector<pollfd>& watched);
  void refuse_silent_and_costly();
  void accept_from(int listening);
  bool make_room(const std::string& network);
  void add(io::Descriptor socket);
  bool hand_over(const Connection& connection);

  const ConnectionLimits limits_;
  std::vector<io::Descriptor> listening_;
  uint32_t port_ = 0;
  std::string path_;  // of a Unix socket
  uint64_t inode_ = 0;
  io::Descriptor wake_;
  Connected connected_;
  std::thread thread_;
  bool is_paused_ = false;       // the thread's: accepts nothing for a moment
  Clock::time_point next_look_;  // the thread's

  mutable std::mutex mutex_;  // guards the rest
  bool stopping_ = false;
  Connections connections_;
  std::unordered_map<std::string, Network> networks_;  // with connections, or barred
  uint64_t refused_ = 0;
  uint32_t handing_over_ = 0;  // threads that are in connected_
  std::condition_variable handed_over_;
};

}  // namespace weir::net
