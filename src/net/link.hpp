// Link: the connection to one server. The only part that uses gRPC.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <memory>
#include <string>

#include "net/address.hpp"
#include "net/oip_messages.hpp"

namespace weir::net {

// Files in PEM; "" = none.
struct Security {
  std::string ca, cert, key, token_file;
  bool insecure = false;  // allows connections to other machines without TLS
};

// An answer, in the memory in which it arrived.
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
                                            size_t most_bytes);
  virtual ~Link() = default;
  static std::string library_version();
  // Sends gRPC's log lines of this process to `log` instead of standard error. `error`: gRPC's
  // severity ERROR.
  static void set_log(void (*log)(bool error, const std::string& text));
  // Sends the request and waits for its end, at the deadline at the latest. `memory` keeps the
  // memory that the pieces borrow; it may be needed after the call has ended.
  virtual Reply call(const std::string& method, const Pieces& request,
                     const std::shared_ptr<const void>& memory, Clock::time_point deadline) = 0;
  // The same without borrowed memory, for probes: where there is no connection, it waits for one.
  // gRPC connects only while a call waits, so calls that fail at once would never connect.
  virtual Reply call_when_connected(const std::string& method, const Pieces& request,
                                    Clock::time_point deadline) = 0;
};

}  // namespace weir::net
