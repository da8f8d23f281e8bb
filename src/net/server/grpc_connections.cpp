// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/grpc_connections.hpp"

namespace weir::net {

Result<std::unique_ptr<grpc::Server>> serve_connections(
    grpc::ServerBuilder* builder, const std::shared_ptr<grpc::ServerCredentials>& credentials,
    ConnectionAcceptor* connections, const std::string& address) {
  using Experimental = grpc::ServerBuilder::experimental_type;
  std::shared_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor =
      builder->experimental().AddExternalConnectionAcceptor(
          Experimental::ExternalConnectionType::FROM_FD, credentials);
  auto server = builder->BuildAndStart();
  if (!server)
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "gRPC did not start a server",
        .offered = address,
        .needed = "memory, threads and descriptors for it, and certificates that it can use",
        .fix =
            "GRPC_VERBOSITY=error and level 4 of the log category weir-net, which have gRPC's "
            "reason"};
  connections->start([acceptor](int socket) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
    connection.fd = socket;
    acceptor->HandleNewConnection(&connection);
  });
  return server;
}

}  // namespace weir::net
