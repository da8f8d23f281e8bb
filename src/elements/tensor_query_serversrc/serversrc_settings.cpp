// Checks and converts the properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_query_serversrc/serversrc_settings.hpp"

#include "core/tensor/frame_spec.hpp"

namespace weir {

net::ListenOptions ServersrcSettings::listen_options() const {
  net::ListenOptions out{.host = host,
                         .port = port,
                         .unix_path = unix_path,
                         .most_bytes = max_message,
                         .most_requests = max_requests,
                         .most_connections = max_connections,
                         .most_address_connections = max_connections_per_address,
                         .most_address_bytes = max_bytes_in_flight,
                         .idle_ms = idle_timeout,
                         .security = {.cert = tls_cert,
                                      .key = tls_key,
                                      .ca = tls_ca,
                                      .token_file = token_file,
                                      .peers = {},
                                      .insecure = insecure},
                         .model_control = model_control};
  if (!tls_peers.empty()) out.security.peers = parse_name_list(tls_peers);
  return out;
}

Status check_protocol(QueryProtocol protocol, QueryConnectType connect_type, const char* element) {
  const std::string fix = std::string(element) + " protocol=oip";
  if (protocol != QueryProtocol::Oip)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the protocol of NNStreamer's query elements is not available yet",
                 .offered = "protocol=edge",
                 .needed = "protocol=oip, the Open Inference Protocol over gRPC",
                 .fix = fix};
  if (connect_type != QueryConnectType::Tcp)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the Open Inference Protocol has no broker",
                 .offered = "connect-type=HYBRID protocol=oip",
                 .needed = "connect-type=TCP",
                 .fix = fix + " connect-type=TCP"};
  return ok();
}

}  // namespace weir
