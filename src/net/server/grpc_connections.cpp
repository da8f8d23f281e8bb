// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/grpc_connections.hpp"

namespace weir::net {

std::unique_ptr<grpc::Server> serve_connections(
    grpc::ServerBuilder* builder, const std::shared_ptr<grpc::ServerCredentials>& credentials,
    ConnectionAcceptor* connections) {
  using Experimental = grpc::ServerBuilder::experimental_type;
  std::shared_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor =
      builder->experimental().AddExternalConnectionAcceptor(
          Experimental::ExternalConnectionType::FROM_FD, credentials);
  auto server = builder->BuildAndStart();
  if (!server) return nullptr;
  connections->start([acceptor](int socket) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
    connection.fd = socket;
    acceptor->HandleNewConnection(&connection);
  });
  return server;
}

}  // namespace weir::net
