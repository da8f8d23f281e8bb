// The broker of connect-type=HYBRID and connect-type=MQTT, from the properties of an element, and
// how an element announces its address there.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "edge/broker_login.hpp"
#include "transport/mqtt/server_discovery.hpp"
#include "transport/network_policy.hpp"
#include "weir/result.hpp"

namespace weir {

struct EdgeBroker {
  std::string host;  // the property dest-host
  uint32_t port = 0;
  BrokerLogin login{};
  bool insecure = false;
  std::string allow{};
};

// The options of its client, after the check whether the connection may go without TLS, whose
// warning it posts. OPTION_VALUE for port 0; CONNECTION_INSECURE.
Result<transport::BrokerOptions> open_options(GstElement* element, const EdgeBroker& broker);

// Posts the warning, or returns the error, of a connection in NNStreamer's protocol without TLS.
Status check_plain_connection(GstElement* element, const transport::Endpoint& endpoint);
// The same for a server that the element is about to connect to, which `allow` must name.
Status check_plain_server(GstElement* element, const transport::Endpoint& endpoint);

// Connects to the broker for an element that listens on `host` and `port`, whose address the broker
// keeps from announce() on. `host` may be "" or 0.0.0.0: all addresses of this machine. Warns of an
// address that only programs of this machine reach, at a broker of another machine. Errors as of
// open_options() and transport::ServerAnnouncement::connect().
Result<std::unique_ptr<transport::ServerAnnouncement>> open_announcement(GstElement* element,
                                                                         const EdgeBroker& broker,
                                                                         const std::string& topic,
                                                                         const std::string& host,
                                                                         uint32_t port);

// Different for each stream: NNStreamer's elements use the time.
std::string unique_device_id();

}  // namespace weir
