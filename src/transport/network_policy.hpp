// Which connections may go without TLS: the rules for protocols of Weir and for those of
// NNStreamer, which have no encryption (SECURITY.md).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/config/configuration.hpp"
#include "weir/result.hpp"

namespace weir::transport {

enum class Role : uint8_t { Connects, Listens };

// A connection that an element is about to open, or an address that it is about to listen on.
struct Endpoint {
  Role role = Role::Connects;
  std::string host{};  // of the peer, or to listen on; an empty one is any address
  uint32_t port = 0;
  bool encrypted = false;
  bool insecure = false;          // the property `insecure`
  std::string allow{};            // the property `allow`: peers, see is_allowed()
  std::string tls_fix{};          // properties that encrypt it, "" where the protocol has no TLS
  std::string to_string() const;  // "host:port", an IPv6 address in brackets
};

// Whether `allow` names the peer: its entries, separated by commas, are host names, addresses, and
// networks as 192.168.1.0/24. An empty text names every peer, a text without entries none.
bool is_allowed(std::string_view allow, std::string_view peer);
// OPTION_VALUE for an entry that is neither a host name, an address nor a network, and for a text
// that is not empty and has no entries.
Status check_allow_list(std::string_view allow);

// CONNECTION_INSECURE for a server that `allow` does not name. A network contains addresses, not
// host names; any name of this machine stands for the others. OPTION_VALUE as of
// check_allow_list().
Status check_server_is_allowed(const Endpoint& endpoint);

// Protocols of Weir. CONNECTION_INSECURE for another machine without TLS and without `insecure`.
Status check_own_protocol(const Endpoint& endpoint);

// Protocols of NNStreamer, which start as there. Returns the warning to post for another machine
// without TLS. CONNECTION_INSECURE if weir.ini has `[network] require-tls=true`, unless `insecure`
// is set and `allow` names the peers. OPTION_VALUE as of check_allow_list().
Result<std::optional<Error>> check_old_protocol(const Endpoint& endpoint,
                                                const config::Configuration& configuration);

}  // namespace weir::transport
