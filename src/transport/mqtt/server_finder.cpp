// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/server_finder.hpp"

#include <poll.h>

#include <algorithm>

namespace weir::transport {

std::optional<ServerChoice::Server> ServerChoice::choose(const std::vector<Server>& servers,
                                                         Clock::time_point now) {
  const auto is_announced = [&](const Failure& failure) {
    return std::ranges::find(servers, failure.announcement, &Server::number) != servers.end();
  };
  std::erase_if(failures_, [&](const Failure& failure) { return !is_announced(failure); });
  for (const auto& server : servers)
    if (std::ranges::find(failures_, server.number, &Failure::announcement) == failures_.end())
      return server;
  if (failures_.empty() || now < failures_.front().time + kRetryTime) return std::nullopt;
  return *std::ranges::find(servers, failures_.front().announcement, &Server::number);
}

io::Deadline ServerChoice::next_retry() const {
  if (failures_.empty()) return std::nullopt;
  return failures_.front().time + kRetryTime;
}

void ServerChoice::failed(const Server& server, Clock::time_point now) {
  std::erase_if(failures_,
                [&](const Failure& failure) { return failure.announcement == server.number; });
  failures_.push_back({server.number, now});
}

Result<std::unique_ptr<ServerFinder>> ServerFinder::open(BrokerOptions options,
                                                         const std::string& topic) {
  auto directory = ServerDirectory::open(std::move(options), topic);
  if (!directory) return directory.error();
  return std::unique_ptr<ServerFinder>(new ServerFinder(*std::move(directory), topic));
}

Result<ServerFinder::Server> ServerFinder::next(const io::Deadline& deadline, int cancel) {
  for (;;) {
    pollfd cancelled{cancel, POLLIN, 0};
    if (poll(&cancelled, 1, 0) > 0)
      return Error{.code = Code::CANCELLED, .what = "the search for a server was cancelled"};
    const uint64_t version = directory_->version();
    const auto servers = directory_->servers();
    const auto now = ServerChoice::Clock::now();
    if (auto server = choice_.choose(servers, deadline ? std::min(now, *deadline) : now))
      return *server;
    if (io::is_over(deadline))
      return Error{
          .code = Code::SERVER_UNREACHABLE,
          .what = "no server of the topic can be reached",
          .offered = std::to_string(servers.size()) + " servers announced for topic=" + topic_,
          .needed = "a server with connect-type=HYBRID and this topic at this broker",
          .fix = "start the server, or correct topic, dest-host and dest-port"};
    directory_->wait_for_change(version, io::earlier(choice_.next_retry(), deadline), cancel);
  }
}

}  // namespace weir::transport
