// What is in gRPC's name of a peer: "ipv4:192.0.2.1:50000", "ipv6:%5B2001:db8::1%5D:50000",
// "unix:".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::net {

// Returns "192.0.2.1", "2001:db8::1", or "" for a Unix socket.
std::string peer_host(const std::string& peer);
// Returns what one owner of addresses cannot have many of: an IPv4 address, a network of IPv6
// ("2001:db8::/64"), or "unix:".
std::string peer_network(const std::string& peer);
// Returns the name of the other end of a socket, in one form for all that gRPC writes; "unix:" if
// it has no address.
std::string peer_name(int socket);
// Returns gRPC's name of a peer in the form of peer_name().
std::string plain_peer_name(const std::string& peer);

}  // namespace weir::net
