// Admission: how many calls each connection, and all together, may have at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

namespace weir::net {

// Thread-safe.
class Admission {
 public:
  // 0 = no limit.
  Admission(uint32_t most_requests, uint32_t most_connections)
      : most_requests_(most_requests), most_connections_(most_connections) {}

  // nullopt: the call is admitted, and leave() ends it. Otherwise why it is not.
  std::optional<std::string> enter(const std::string& peer) {
    std::lock_guard lock(mutex_);
    const auto known = calls_.find(peer);
    if (known == calls_.end() && most_connections_ != 0 && calls_.size() >= most_connections_)
      return refused("the server serves " + std::to_string(most_connections_) +
                     " connections at a time (max-connections)");
    // Connections to a Unix socket all have the same name.
    const bool is_one_connection = peer.rfind("unix:", 0) != 0;
    if (known != calls_.end() && is_one_connection && most_requests_ != 0 &&
        known->second >= most_requests_)
      return refused("this connection has " + std::to_string(most_requests_) +
                     " requests in progress (max-requests)");
    ++calls_[peer];
    return std::nullopt;
  }
  void leave(const std::string& peer) {
    std::lock_guard lock(mutex_);
    const auto known = calls_.find(peer);
    if (known != calls_.end() && --known->second == 0) calls_.erase(known);
  }
  uint64_t refused() const {
    std::lock_guard lock(mutex_);
    return refused_;
  }

 private:
  std::string refused(std::string why) {
    ++refused_;
    return why;
  }

  const uint32_t most_requests_, most_connections_;
  mutable std::mutex mutex_;                         // guards the rest
  std::unordered_map<std::string, uint32_t> calls_;  // by peer
  uint64_t refused_ = 0;
};

}  // namespace weir::net
