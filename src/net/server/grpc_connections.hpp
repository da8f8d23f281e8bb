// serve_connections(): a gRPC server for the connections of a ConnectionAcceptor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "net/server/connection_acceptor.hpp"

namespace weir::net {

// Stop `connections` before the server. OPTION_VALUE if gRPC does not start it; `address` is that
// of the error.
Result<std::unique_ptr<grpc::Server>> serve_connections(
    grpc::ServerBuilder* builder, const std::shared_ptr<grpc::ServerCredentials>& credentials,
    ConnectionAcceptor* connections, const std::string& address);

}  // namespace weir::net
