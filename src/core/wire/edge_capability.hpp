// The texts of CAPABILITY and HOST_INFO messages (docs/compatibility/edge-wire.md 10.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::wire {

// The text of a memory up to its first NUL. PEER_MESSAGE_INVALID without a NUL.
Result<std::string_view> text_of_memory(std::span<const std::byte> memory);

// What a query server takes and answers, as caps.
struct QueryCapability {
  std::string source_caps;  // of the server's source: what clients send
  std::string sink_caps;    // of the server's sink: what clients receive
};
// Both caps in one text. OPTION_VALUE if they contain `@` or NUL, which no peer could separate.
Result<std::string> query_capability_text(const QueryCapability& capability);
// PEER_MESSAGE_INVALID if one of the two is missing or empty: a server that has just started may
// send half of them.
Result<QueryCapability> parse_query_capability(std::string_view text);

// The caps that a publisher sends, which are empty while it does not know them.
Result<std::string> publisher_capability_text(std::string_view caps);
// PEER_MESSAGE_INVALID if the text is not one of a publisher.
Result<std::string> parse_publisher_capability(std::string_view text);

// A host name or IPv4 address, and a port.
struct HostAddress {
  std::string host;
  uint16_t port = 0;

  std::string to_string() const { return host + ":" + std::to_string(port); }
  bool operator==(const HostAddress&) const = default;
};
// Reads `host:port`, split at the first colon. PEER_MESSAGE_INVALID without a colon, for a port
// that is not 1 to 65535, and for a host that is empty, longer than 253 characters or has other
// characters than letters, digits, `.`, `-` and `_`.
Result<HostAddress> parse_host_address(std::string_view text);

// Where a server connects to for a client whose connection comes from the IPv4 address
// `peer_address` and whose HOST_INFO says `announced`. Names of the client's own machine
// (`localhost`, 127.x.x.x, 0.0.0.0) are `peer_address`. PEER_MESSAGE_INVALID for any other host
// that is not in `allowed`: otherwise a client could make the server connect anywhere.
Result<HostAddress> callback_address(const HostAddress& announced, std::string_view peer_address,
                                     std::span<const std::string> allowed);

}  // namespace weir::wire
