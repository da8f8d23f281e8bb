// The properties of edgesrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "edge/broker_login.hpp"
#include "edge/edge_connect_type.hpp"

namespace weir {

struct EdgesrcSettings : BrokerLogin {
  std::optional<std::string> host;
  uint32_t port = 0;
  std::string dest_host = "localhost";
  uint32_t dest_port = 3000;
  EdgeConnectType connect_type = EdgeConnectType::Tcp;
  std::optional<std::string> topic, custom_lib;
  EdgeProtocol protocol = EdgeProtocol::Edge;
  std::string path;
  bool reconnect = false;
  uint64_t max_message = uint64_t{64} << 20;
  bool insecure = false;
  std::string allow;
};

}  // namespace weir
