// Why a client and a broker did not agree on TLS: libmosquitto reports one number for all reasons.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mosquitto.h>

#include <optional>
#include <string>

#include "transport/mqtt/mqtt_message.hpp"

namespace weir::transport {

// Whether OpenSSL has data of the broker that the socket no longer has: poll() does not report it.
bool has_unread_tls_data(mosquitto* client);

// What OpenSSL says in a line of the log of libmosquitto; "" for other lines.
std::string tls_error_of_log(const char* line);

// BROKER_REFUSED with what to do, after a client could not connect; nullopt if TLS is not the
// reason. `error` is the first of tls_error_of_log(), or "". Connects to the broker once more, for
// the result of the verification, which the library hides; takes up to 5 s.
std::optional<Error> find_tls_failure(const BrokerOptions& options, const std::string& error);

}  // namespace weir::transport
