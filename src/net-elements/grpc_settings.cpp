// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net-elements/grpc_settings.hpp"

#include "gstcpp/element/error.hpp"
#include "transport/network_policy.hpp"

namespace weir {

Result<net::TensorServiceOptions> GrpcSettings::options(const MessageCodec& codec,
                                                        GstElement* element) const {
  const transport::Endpoint endpoint{
      .role = server ? transport::Role::Listens : transport::Role::Connects,
      .host = host,
      .port = static_cast<uint32_t>(port),
      .insecure = insecure,
      .allow = allow};
  if (!server)
    if (auto status = transport::check_server_is_allowed(endpoint); !status) return status.error();
  auto warning = transport::check_old_protocol(endpoint, config::Configuration::load());
  if (!warning) return warning.error();
  if (*warning) gst::post_warning(element, **warning);
  net::TensorServiceOptions out;
  out.package = codec.package();
  out.empty = codec.empty();
  out.host = host;
  out.port = static_cast<uint32_t>(port);
  out.server = server;
  out.max_bytes = max_message;
  out.max_connections = max_connections;
  out.max_address_connections = max_connections_per_address;
  if (!allow.empty())
    out.allows = [list = allow](const std::string& peer) {
      return transport::is_allowed(list, peer);
    };
  out.warn = [element](const Error& error) { gst::post_warning(element, error); };
  return out;
}

}  // namespace weir
