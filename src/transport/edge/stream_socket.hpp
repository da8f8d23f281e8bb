// TCP sockets of NNStreamer's streams: IPv4, never blocking.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>

#include "core/io/deadline.hpp"
#include "core/wire/edge_capability.hpp"
#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::edge {

using io::Descriptor;

// Listens on an address of this machine; port 0 takes a free one. OPTION_VALUE if it cannot.
Result<Descriptor> listen_on(const std::string& host, uint32_t port);
// The port that a socket has at this end; 0 if it is unknown.
uint16_t get_port(int socket) noexcept;
// The next connection that waits; no descriptor if there is none.
Descriptor accept_from(int listener) noexcept;
// The IPv4 address of the other end, as text.
std::string get_peer(int socket);

// A number by which a server or publisher knows a peer. Random, so that it cannot be guessed, and
// positive: 62 bits.
int64_t new_client_id();

// Connects. `cancel` is a borrowed descriptor that ends waiting when readable, or -1.
// SERVER_UNREACHABLE; CANCELLED.
Result<Descriptor> connect_to(const std::string& host, uint32_t port, const io::Deadline& deadline,
                              int cancel);

// Whether `host` is an IPv4 address in numbers.
bool is_address(const std::string& host);
// Begins to connect to an IPv4 address in numbers, without waiting. SERVER_UNREACHABLE.
Result<Descriptor> start_connection(const wire::HostAddress& address);
// Whether a connection that was begun is there.
bool is_connected(int socket) noexcept;
// Why it cannot be made; "" while it may come.
std::string connection_error(int socket);

}  // namespace weir::edge
