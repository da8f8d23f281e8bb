// Which texts the headers of a call (gRPC: metadata) can carry.
//
// gRPC accepts other bytes from a peer, but ends the process that sends them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string_view>

namespace weir::net {

// Whether a header can have this value: printable ASCII.
bool is_header_value(std::string_view text);
// Whether this is a `traceparent` as W3C's Trace Context defines it: VERSION-TRACE-SPAN-FLAGS, all
// of them lower-case hexadecimal digits.
bool is_trace_parent(std::string_view text);

}  // namespace weir::net
