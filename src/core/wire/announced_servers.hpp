// The servers that a broker announces for one topic (docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/wire/edge_capability.hpp"
#include "weir/result.hpp"

namespace weir::wire {

// One address for each MQTT topic, oldest first. A server that announces again moves to the end; a
// server that withdraws its address is removed. One thread at a time.
class AnnouncedServers {
 public:
  // Anyone may publish to a broker.
  static constexpr size_t kMaxServers = 256;

  // A message that the broker delivered. PEER_MESSAGE_INVALID for a payload that is no address,
  // which changes nothing, and for one server more than kMaxServers.
  Status update(std::string_view topic, std::span<const std::byte> payload);

  struct Server {
    std::string topic;
    HostAddress address;
    uint64_t number;  // of the announcement: each has a higher one than those before
  };
  const std::vector<Server>& servers() const noexcept { return servers_; }

 private:
  std::vector<Server> servers_;
  uint64_t announcements_ = 0;
};

}  // namespace weir::wire
