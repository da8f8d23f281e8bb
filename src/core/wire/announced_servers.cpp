// The servers that a broker announces for one topic (docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/announced_servers.hpp"

#include "core/wire/mqtt_frame.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {

Status AnnouncedServers::update(std::string_view topic, std::span<const std::byte> payload) {
  auto address = parse_announcement(payload);
  if (!address) return address.error();
  std::erase_if(servers_, [topic](const Server& server) { return server.topic == topic; });
  if (!*address) return ok();
  if (servers_.size() == kMaxServers)
    return peer_error(
        "a broker announces too many servers",
        std::to_string(kMaxServers + 1) + " servers, the last one at " + quoted_text(topic),
        "at most " + std::to_string(kMaxServers),
        "remove retained messages of servers that no longer exist from the broker");
  servers_.push_back({std::string(topic), **std::move(address), ++announcements_});
  return ok();
}

}  // namespace weir::wire
