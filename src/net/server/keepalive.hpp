// set_keepalive(): how a server notices clients that froze, or went without closing their
// connections.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/grpcpp.h>

namespace weir::net {

// A connection that is silent for ten seconds gets a ping, and ends when the response is missing
// for ten more; gRPC's own default is two hours. Less than five would end clients that only wait:
// gRPC clients without a call read their connections every five seconds.
inline void set_keepalive(grpc::ServerBuilder* builder) {
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
}

}  // namespace weir::net
