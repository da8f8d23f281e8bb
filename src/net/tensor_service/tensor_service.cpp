// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/tensor_service/tensor_service.hpp"

#include "net/server/server_security.hpp"
#include "net/tensor_service/tensor_endpoints.hpp"

namespace weir::net {
namespace {

Result<std::unique_ptr<TensorEndpoint>> open(const TensorServiceOptions& options,
                                             OutgoingFrames* outgoing, IncomingFrames* incoming) {
  if (options.server) return serve_tensors(options, outgoing, incoming);
  return connect_tensors(options, outgoing, incoming);
}

}  // namespace

std::string address_text(const TensorServiceOptions& options) {
  ListenOptions address;
  address.host = options.host;
  address.port = options.port;
  return address_text(address);
}

Result<std::unique_ptr<TensorEndpoint>> open_sender(const TensorServiceOptions& options,
                                                    OutgoingFrames* frames) {
  return open(options, frames, nullptr);
}

Result<std::unique_ptr<TensorEndpoint>> open_receiver(const TensorServiceOptions& options,
                                                      IncomingFrames* frames) {
  return open(options, nullptr, frames);
}

}  // namespace weir::net
