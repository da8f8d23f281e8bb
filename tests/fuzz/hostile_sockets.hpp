// HostilePeer: plays a fuzz input as a peer that keeps to no rule, on sockets of this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "fuzz_input.hpp"
#include "hostile_messages.hpp"
#include "machine/descriptor.hpp"
#include "transport/local/local_socket.hpp"

namespace weir::fuzz {

class HostilePeer {
 public:
  // The side of Weir: a server listens on `port` or at `path`, a client connects to `path` or to
  // the port of this peer.
  struct Victim {
    Protocol protocol = Protocol::Stream;
    bool is_server = false;
    uint16_t port = 0;
    std::string path;
  };
  explicit HostilePeer(Victim victim);
  HostilePeer(const HostilePeer&) = delete;
  HostilePeer& operator=(const HostilePeer&) = delete;
  ~HostilePeer() { leave(); }

  uint16_t port() const;  // on which this peer listens
  // Plays the input, for at most kMaxTime. Afterwards the connections stay open and floods go on.
  void play(FuzzInput* input);
  // Ends the floods and closes everything.
  void leave();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kMaxTime = std::chrono::milliseconds(200);
  static constexpr size_t kMaxConnections = 8, kMaxFloods = 2;

  struct Connection {
    io::Descriptor socket;
    Conversation conversation;
    Bytes received;  // the first bytes that came
  };

  bool wait(int socket, short events, int milliseconds) const;
  void act(FuzzInput* input);
  Connection* choose(FuzzInput* input);
  Connection* connect();
  Connection* add(io::Descriptor socket);
  io::Descriptor connect_to(const char* own_address, uint16_t port) const;
  io::Descriptor accept() const;
  void begin(Connection* connection);
  void begin_edge(Connection* connection);
  void begin_mqtt(Connection* connection) const;
  void connect_back(const Connection& connection);
  void read(Connection* connection, size_t wanted) const;
  static void send(const Connection& connection, const HostileMessage& message);
  void say(Connection* connection, uint32_t kind) const;
  void say_changed(Connection* connection, FuzzInput* input) const;
  void flood(Connection* connection, uint32_t kind);
  void run_flood(io::Descriptor socket, Conversation conversation, uint32_t kind) const;
  void close(const Connection* connection, bool with_reset);
  void come_and_go(uint32_t times);

  const Victim victim_;
  io::Descriptor listener_;
  std::optional<local::Listener> local_listener_;
  Clock::time_point end_;
  std::vector<std::unique_ptr<Connection>> connections_;
  std::atomic<bool> stopping_{false};
  std::vector<std::thread> floods_;
};

}  // namespace weir::fuzz
