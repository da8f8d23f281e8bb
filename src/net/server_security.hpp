// Whether the options of a server are safe and belong together, and its files.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "net/listener.hpp"

namespace weir::net {

// CONNECTION_INSECURE for other machines without TLS and for tokens without TLS; OPTION_VALUE for
// options that do not fit.
Status check_security(const ListenOptions& options);
// The text of the file of a property. FILE_NOT_FOUND, also for an empty one.
Result<std::string> read_security_file(const std::string& path, const char* property);
// Whether only programs of this machine can connect.
bool is_local(const ListenOptions& options);
// "host:port" as gRPC writes it, or "unix:PATH".
std::string address_text(const ListenOptions& options);

}  // namespace weir::net
