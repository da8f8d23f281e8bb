// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edge_broker.hpp"

#include "gstcpp/element/error.hpp"
#include "machine/loopback.hpp"

namespace weir {

Status check_plain_connection(GstElement* element, const transport::Endpoint& endpoint) {
  const auto warning = transport::check_old_protocol(endpoint, config::Configuration::load());
  if (!warning) return warning.error();
  if (*warning) gst::post_warning(element, **warning);
  return ok();
}

Status check_plain_server(GstElement* element, const transport::Endpoint& endpoint) {
  if (auto status = transport::check_server_is_allowed(endpoint); !status) return status;
  return check_plain_connection(element, endpoint);
}

Result<transport::BrokerOptions> open_options(GstElement* element, const EdgeBroker& broker) {
  if (broker.port == 0)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the port of the broker cannot be used",
                 .offered = "dest-port=0",
                 .needed = "a number from 1 to 65535",
                 .fix = "dest-port=1883"};
  transport::BrokerOptions out;
  out.host = broker.host;
  out.port = static_cast<uint16_t>(broker.port);
  out.address_properties = "dest-host and dest-port";
  broker.login.set(&out);
  if (auto status = check_plain_connection(element, {.host = broker.host,
                                                     .port = broker.port,
                                                     .encrypted = out.tls.is_enabled(),
                                                     .insecure = broker.insecure,
                                                     .allow = broker.allow,
                                                     .tls_fix = "tls-ca=ca.pem dest-port=8883"});
      !status)
    return status.error();
  return out;
}

namespace {

void warn_of_local_address(GstElement* element, const EdgeBroker& broker, const std::string& host) {
  if (!is_loopback(host) || is_loopback(broker.host)) return;
  gst::post_warning(
      element,
      Error{.code = Code::OPTION_VALUE,
            .what = "the address announced to the broker is reachable from this machine only",
            .offered = "host=" + host,
            .needed = "an address of this machine that other machines can reach",
            .fix = "host=0.0.0.0, which listens on all addresses and announces the one used to "
                   "reach the broker"});
}

}  // namespace

Result<std::unique_ptr<transport::ServerAnnouncement>> open_announcement(GstElement* element,
                                                                         const EdgeBroker& broker,
                                                                         const std::string& topic,
                                                                         const std::string& host,
                                                                         uint32_t port) {
  auto options = open_options(element, broker);
  if (!options) return options.error();
  const bool listens_on_all = host.empty() || host == "0.0.0.0";
  if (!listens_on_all) warn_of_local_address(element, broker, host);
  return transport::ServerAnnouncement::connect(
      *std::move(options), unique_device_id(), topic,
      {listens_on_all ? "" : host, static_cast<uint16_t>(port)});
}

std::string unique_device_id() {
  return std::to_string(g_get_real_time()) + std::to_string(g_random_int());
}

}  // namespace weir
