// Link: the connection to one server. The only part that uses gRPC.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "net/protocol/oip_messages.hpp"

namespace weir::net {

// Where a model is served, as users write it.
//
//   grpc://127.0.0.1:8001/resnet/1        plain, for this machine
//   grpcs://host:8001/resnet              TLS, any version of the model
//   grpc+unix:/run/weir.sock:/resnet      a Unix socket
//   grpcs:dns:///farm.example:8001/resnet     one name with several addresses
struct ServerAddress {
  std::string text;        // as written, for errors and logs
  std::string target;      // gRPC's name of it: "127.0.0.1:8001", "unix:/run/weir.sock"
  std::string model;       // name of the model on the server
  std::string version;     // "" = the server chooses
  bool encrypted = false;  // TLS
  bool local = false;      // loopback or a Unix socket

  // OPTION_VALUE for a text of another form.
  static Result<ServerAddress> parse(std::string_view text);
};

// Files in PEM; "" = none.
struct Security {
  std::string ca, cert, key, token_file;
  bool insecure = false;  // allows connections to other machines without TLS
};

// A response, in the memory in which it arrived.
struct Reply {
  int status = 0;       // of gRPC; 0 = OK
  std::string message;  // of the server when the status is not OK
  Chunks chunks;
  std::shared_ptr<const void> memory;  // of the chunks
};

// Thread-safe.
class Link {
 public:
  using Clock = std::chrono::steady_clock;
  // Connects with the first call. CONNECTION_INSECURE for another machine without TLS,
  // FILE_NOT_FOUND and OPTION_VALUE for files and options that do not fit.
  static Result<std::unique_ptr<Link>> open(const ServerAddress& address, const Security& security,
                                            size_t max_bytes);
  virtual ~Link() = default;
  static std::string library_version();
  // Sends gRPC's log lines of this process to `log` instead of standard error. `error`: gRPC's
  // severity ERROR.
  static void set_log(void (*log)(bool error, const std::string& text));
  // Sends the request and waits for its end, at the deadline at the latest. `memory` keeps the
  // memory that the pieces borrow; it may be needed after the call has ended.
  virtual Reply call(const std::string& method, const Pieces& request,
                     const std::shared_ptr<const void>& memory, Clock::time_point deadline) = 0;
  // Does the same without borrowed memory, for probes, and waits for a connection where there is
  // none.
  // gRPC connects only while a call waits, so calls that fail at once would never connect.
  virtual Reply call_when_connected(const std::string& method, const Pieces& request,
                                    Clock::time_point deadline) = 0;
};

}  // namespace weir::net
