// The two sides of TensorService over gRPC; open_sender() and open_receiver() choose one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "net/tensor_service/tensor_service.hpp"

namespace weir::net {

inline constexpr char kSendTensors[] = "SendTensors", kRecvTensors[] = "RecvTensors";

// "/nnstreamer.protobuf.TensorService/SendTensors"
inline std::string method_path(const TensorServiceOptions& options, const char* method) {
  return "/" + options.package + ".TensorService/" + method;
}

// One of the two is null.
Result<std::unique_ptr<TensorEndpoint>> serve_tensors(const TensorServiceOptions& options,
                                                      OutgoingFrames* outgoing,
                                                      IncomingFrames* incoming);
std::unique_ptr<TensorEndpoint> connect_tensors(const TensorServiceOptions& options,
                                                OutgoingFrames* outgoing, IncomingFrames* incoming);

}  // namespace weir::net
