// ServerFinder: which of the servers that a broker announces a client connects to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "transport/mqtt/server_discovery.hpp"

namespace weir::transport {

// The choice itself, without a broker. One thread at a time.
class ServerChoice {
 public:
  using Clock = std::chrono::steady_clock;
  using Server = wire::AnnouncedServers::Server;
  // A server that failed is tried again after this time, or when it announces itself again.
  static constexpr auto kRetryTime = std::chrono::seconds(1);

  // Servers that did not fail come first, in the order of their announcements; then the one that
  // failed longest ago, once kRetryTime has passed. Nullopt if none may be tried now.
  std::optional<Server> choose(const std::vector<Server>& servers, Clock::time_point now);
  // When the next server may be tried that failed; nullopt if none did.
  io::Deadline next_retry() const;
  void failed(const Server& server, Clock::time_point now);

 private:
  struct Failure {
    uint64_t announcement;
    Clock::time_point time;
  };
  std::vector<Failure> failures_;  // the oldest first
};

// Used by one thread:
//
//   for (;;) {
//     auto server = finder->next(deadline, cancel);
//     if (!server) return server.error();
//     auto connection = connect_to(server->address);
//     if (connection) return connection;
//     finder->failed(*server);  // also when a connection is lost later
//   }
class ServerFinder {
 public:
  using Server = ServerChoice::Server;

  // Errors as of ServerDirectory::open().
  static Result<std::unique_ptr<ServerFinder>> open(BrokerOptions options,
                                                    const std::string& topic);

  // The server to try next; waits for one. CANCELLED when the borrowed descriptor `cancel` is
  // readable, -1 = none; SERVER_UNREACHABLE after the deadline. A server that failed less than
  // kRetryTime before the deadline is not tried again, however often this is called.
  Result<Server> next(const io::Deadline& deadline, int cancel);
  // Others go first from now on.
  void failed(const Server& server) { choice_.failed(server, ServerChoice::Clock::now()); }
  // How many servers are announced. Any thread.
  size_t count() const { return directory_->servers().size(); }

 private:
  ServerFinder(std::unique_ptr<ServerDirectory> directory, std::string topic)
      : directory_(std::move(directory)), topic_(std::move(topic)) {}

  const std::unique_ptr<ServerDirectory> directory_;
  const std::string topic_;
  ServerChoice choice_;
};

}  // namespace weir::transport
