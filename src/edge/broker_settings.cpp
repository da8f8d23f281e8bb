// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/broker_settings.hpp"

#include <unistd.h>

#include <atomic>
#include <charconv>

#include "gstcpp/element/error.hpp"
#include "transport/host_text.hpp"
#include "transport/network_policy.hpp"

namespace weir {

Result<transport::BrokerOptions> broker_options(const BrokerSettings& settings) {
  transport::BrokerOptions out;
  const transport::HostText address = transport::read_host(settings.host);
  const bool is_default = settings.port == BrokerSettings().port;
  const std::string port =
      address.port && is_default ? std::to_string(*address.port) : settings.port;
  const auto [end, fault] = std::from_chars(port.data(), port.data() + port.size(), out.port);
  if (fault != std::errc{} || end != port.data() + port.size() || out.port == 0)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the port of the broker cannot be read",
                 .offered = "port=" + port,
                 .needed = "a number from 1 to 65535",
                 .fix = "port=1883"};
  out.host = address.host;
  out.client_id = settings.client_id;
  out.version = settings.is_v5() ? transport::MqttVersion::V5 : transport::MqttVersion::V311;
  out.clean_session = settings.cleansession;
  out.keep_alive = settings.keep_alive_interval;
  settings.set(&out);
  return out;
}

Status check_connection(GstElement* element, const transport::BrokerOptions& options,
                        const BrokerSettings& settings) {
  const transport::Endpoint endpoint{.host = options.host,
                                     .port = options.port,
                                     .encrypted = options.tls.is_enabled(),
                                     .insecure = settings.insecure,
                                     .allow = settings.allow,
                                     .tls_fix = "tls-ca=ca.pem port=8883"};
  if (settings.is_v5()) return transport::check_own_protocol(endpoint);
  auto warning = transport::check_old_protocol(endpoint, config::Configuration::load());
  if (!warning) return warning.error();
  if (*warning) gst::post_warning(element, **warning);
  return ok();
}

std::string default_client_id(const char* kind) {
  static std::atomic<unsigned> next{0};
  return std::string(g_get_host_name()) + "_" + std::to_string(getpid()) + "_" + kind +
         std::to_string(next++);
}

}  // namespace weir
