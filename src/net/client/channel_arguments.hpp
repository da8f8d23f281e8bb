// channel_arguments(): how clients of gRPC connect, and how large their messages may be.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <cstdint>

namespace weir::net {

inline grpc::ChannelArguments channel_arguments(size_t max_bytes) {
  grpc::ChannelArguments out;
  const int max = static_cast<int>(std::min<size_t>(max_bytes, INT32_MAX));
  out.SetMaxReceiveMessageSize(max);
  out.SetMaxSendMessageSize(max);
  out.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  out.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  out.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  // gRPC's "minimum" is the time that it gives an attempt to connect, TLS included.
  out.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 10'000);
  out.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1000);
  out.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return out;
}

}  // namespace weir::net
