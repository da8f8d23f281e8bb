// Listener: receives calls of gRPC clients on one address. The only part of the server that uses
// gRPC.
//
//   auto listener = Listener::open(options, [](std::shared_ptr<Call> call) {
//     call->fail(CallStatus::Unimplemented, "nothing is served here");
//   });
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "net/server/call.hpp"

namespace weir::net {

// Files in PEM; "" = none. Files that change are read again.
struct ServerSecurity {
  std::string cert, key;  // of this server: TLS
  std::string ca;         // clients need a certificate of this authority
  std::string token_file;
  std::vector<std::string> peers;  // names (SAN) that a client's certificate may have; none = any
  bool insecure = false;           // allows other machines to connect without TLS
  bool operator==(const ServerSecurity&) const = default;
};

struct ListenOptions {
  std::string host = "localhost";
  uint32_t port = 0;                                 // 0 = a free port
  std::string unix_path;                             // instead of host and port
  size_t max_bytes = size_t{64} << 20;               // of one message
  uint32_t max_requests = 8;                         // of one connection at a time; 0 = no limit
  uint32_t max_connections = 32;                     // that have requests; 0 = no limit
  uint32_t max_address_connections = 4;              // of one address; 0 = no limit
  uint64_t max_address_bytes = uint64_t{256} << 20;  // of its requests in progress; 0 = no limit
  // The time after which a connection without calls is closed, and a call ends whose message has
  // not come or whose response is not read.
  uint32_t idle_ms = 300'000;
  ServerSecurity security;
  bool model_control = false;  // clients may load and unload models; of ModelServer
  bool operator==(const ListenOptions&) const = default;
};

// Whether a method has streams of messages: `/grpc.health.v1.Health/Watch` and reflection.
bool is_stream_method(std::string_view method);

// Thread-safe.
class Listener {
 public:
  // Called on a thread of gRPC with each call whose request has arrived, and with each message of a
  // stream, as a call of its own; must not block. A call whose message does not come for ten
  // seconds ends.
  using Handler = std::function<void(std::shared_ptr<Call>)>;
  // CONNECTION_INSECURE for other machines without TLS; FILE_NOT_FOUND for files, and OPTION_VALUE
  // for options and addresses, that cannot be used.
  static Result<std::unique_ptr<Listener>> open(const ListenOptions& options, Handler handler);
  // Waits until all calls have ended: end the calls that you hold first.
  virtual ~Listener() = default;
  virtual uint32_t port() const noexcept = 0;  // 0 for a Unix socket
  // Calls that were refused before the handler, and connections that were closed: token,
  // certificate, limits.
  virtual uint64_t refused() const noexcept = 0;
};

}  // namespace weir::net
