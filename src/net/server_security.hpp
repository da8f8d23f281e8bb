// Who may connect to a server: its certificates, the tokens and the names of clients.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "net/listener.hpp"

namespace weir::net {

// The files of ServerSecurity, read.
struct ServerSecrets {
  std::string cert, key, ca;        // PEM
  std::vector<std::string> tokens;  // a client needs one of them; empty = all may connect
};

// CONNECTION_INSECURE for other machines without TLS and for tokens without TLS; FILE_NOT_FOUND and
// OPTION_VALUE for files and options that do not fit.
Result<ServerSecrets> read_secrets(const ListenOptions& options);
// Whether only programs of this machine can connect.
bool is_local(const ListenOptions& options);
// "host:port" as gRPC writes it, or "unix:PATH".
std::string address_text(const ListenOptions& options);
// Whether `header`, "Bearer TOKEN", has one of the tokens. Takes the same time for all of a length.
bool has_token(const ServerSecrets& secrets, std::string_view header);

}  // namespace weir::net
