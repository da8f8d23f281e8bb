// Whether the options of a server are safe and belong together.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "net/server/listener.hpp"

namespace weir::net {

// CONNECTION_INSECURE for other machines without TLS and for tokens without TLS; OPTION_VALUE for
// options that do not fit.
Status check_security(const ListenOptions& options);
// Whether only programs of this machine can connect.
bool is_local(const ListenOptions& options);
// "host:port" as gRPC writes it, or "unix:PATH".
std::string address_text(const ListenOptions& options);

}  // namespace weir::net
