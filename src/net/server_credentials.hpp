// What a server shows to clients, and asks of them: certificates, which are read again when their
// files change.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "net/listener.hpp"

namespace weir::net {

// Plain without a certificate. FILE_NOT_FOUND; OPTION_VALUE for a certificate and a key that cannot
// be read or do not belong together.
Result<std::shared_ptr<grpc::ServerCredentials>> server_credentials(const ServerSecurity& security);

}  // namespace weir::net
