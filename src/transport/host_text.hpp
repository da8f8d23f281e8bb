// Addresses as NNStreamer's users write them into host and dest-host: "tcp://HOST", "mqtt://HOST",
// "HOST:PORT" (docs/compatibility/io.md 7.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace weir::transport {

struct HostText {
  std::string host;              // without scheme and port
  std::optional<uint16_t> port;  // that follows the host; 1 to 65535
};
// An IPv6 address has no port unless it is in brackets. Other text remains as it is.
HostText read_host(std::string_view text);

// Whether the text may be a host name or an address: neither has blanks.
bool may_be_host(std::string_view text);

// Reads the host. A port behind it counts where the property `port` has its default.
void read_address(std::string* host, uint32_t* port, uint32_t default_port);

}  // namespace weir::transport
