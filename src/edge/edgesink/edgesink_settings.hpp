// The properties of edgesink.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "edge/broker_login.hpp"
#include "edge/edge_connect_type.hpp"

namespace weir {

struct EdgesinkSettings : BrokerLogin {
  EdgeProtocol protocol = EdgeProtocol::Edge;
  EdgeConnectType connect_type = EdgeConnectType::Tcp;
  std::string host = "localhost", dest_host = "localhost";
  uint32_t port = 3000, dest_port = 3000;
  std::optional<std::string> topic, custom_lib;
  bool wait_connection = false;
  uint64_t connection_timeout = 0;  // ms; 0 = no limit
  std::string path;
  uint32_t max_buffers = 16;
  bool drop = false;
  WireVersion wire_version = WireVersion::Bytes2088;
  bool insecure = false;
  std::string allow;
};

}  // namespace weir
