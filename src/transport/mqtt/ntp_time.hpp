// The time of NTP servers (RFC 5905), for the epochs of mqttsink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

#include "weir/result.hpp"

namespace weir::transport {

// Asks `servers`, "host:port,host:port", in turn with one 48-byte request each and returns what to
// add to this machine's Unix time, in ns. SERVER_UNREACHABLE if none answers within `timeout`,
// OPTION_VALUE for a text without a server.
Result<int64_t> ntp_offset(const std::string& servers, std::chrono::seconds timeout);

// This machine's Unix time in ns.
int64_t unix_time();

}  // namespace weir::transport
