// NNStreamer's service TensorService (docs/compatibility/io.md 7.6): messages of tensors go to a
// server by SendTensors, or come from it by RecvTensors.
//
//   OutgoingFrames frames({.queue = 16, .waits = true, .keeps = !options.server});
//   auto endpoint = open_sender(options, &frames);
//   frames.send(message);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "net/tensor_service/incoming_frames.hpp"
#include "net/tensor_service/outgoing_frames.hpp"
#include "weir/result.hpp"

namespace weir::net {

struct TensorServiceOptions {
  std::string package = "nnstreamer.protobuf";  // of the service
  std::string empty;                            // the bytes of its message Empty
  std::string host = "localhost";
  uint32_t port = 55115;  // a server's 0 = a free port
  bool server = false;
  size_t max_bytes = size_t{64} << 20;  // of one message
  // Of a server, with calls in progress; 0 = no limit.
  uint32_t max_connections = 32, max_address_connections = 16;
  // Whether a server accepts calls from this address; empty: from all.
  std::function<bool(const std::string& host)> allows;
  // Called on any thread with what degrades the stream: a server that cannot be reached, a peer
  // whose messages were refused.
  std::function<void(const Error&)> warn;
};

// "localhost:55115", with brackets around an IPv6 address.
std::string address_text(const TensorServiceOptions& options);

// A server, or the connection to one. Its end ends all calls.
class TensorEndpoint {
 public:
  virtual ~TensorEndpoint() = default;
  virtual uint32_t port() const noexcept = 0;
};

// Sends what `frames` receives: a server to each client of RecvTensors, a client by SendTensors.
// `frames` must live longer. OPTION_VALUE for an address that a server cannot listen on; a client
// connects in the background and again whenever the connection is lost.
Result<std::unique_ptr<TensorEndpoint>> open_sender(const TensorServiceOptions& options,
                                                    OutgoingFrames* frames);
// Receives in the other direction: a server takes the messages of each client of SendTensors, a
// client those of RecvTensors.
Result<std::unique_ptr<TensorEndpoint>> open_receiver(const TensorServiceOptions& options,
                                                      IncomingFrames* frames);

}  // namespace weir::net
