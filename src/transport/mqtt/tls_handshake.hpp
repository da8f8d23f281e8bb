// TlsHandshake: why a client and a broker did not agree on TLS. libmosquitto reports one number for
// all reasons.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mosquitto.h>
#include <openssl/ssl.h>

#include <memory>
#include <optional>
#include <string>

#include "transport/mqtt/mqtt_message.hpp"

namespace weir::transport {

// Lives as long as the attempt to connect. Used by the thread of the client, whose log callback it
// sets for that time.
class TlsHandshake {
 public:
  explicit TlsHandshake(mosquitto* client);
  TlsHandshake(const TlsHandshake&) = delete;
  TlsHandshake& operator=(const TlsHandshake&) = delete;
  ~TlsHandshake();

  // Called after the client began to connect, and before the library reads.
  void begin();
  // A line of the log of libmosquitto.
  void log(const char* line);
  // BROKER_REFUSED with what to do; nullopt if TLS is not the reason. `host` is the name that was
  // looked for in the certificate.
  std::optional<Error> failure(const BrokerOptions& options) const;

 private:
  struct Free {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  mosquitto* const client_;
  std::unique_ptr<SSL, Free> ssl_;  // outlives that of the library
  std::string error_;               // OpenSSL's first
};

}  // namespace weir::transport
