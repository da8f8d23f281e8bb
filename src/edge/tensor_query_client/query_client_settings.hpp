// The properties of tensor_query_client.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "edge/broker_login.hpp"
#include "edge/serversrc_settings.hpp"

namespace weir {

struct QueryClientSettings : BrokerLogin {
  std::string host = "localhost";
  uint32_t port = 3001;
  std::string dest_host = "localhost";
  uint32_t dest_port = 3000;
  QueryConnectType connect_type = QueryConnectType::Tcp;
  std::optional<std::string> topic;
  uint32_t timeout = 0;
  bool silent = true;
  uint32_t max_request = 2;
  bool reconnect = false;
  uint64_t max_message = uint64_t{64} << 20;
  bool insecure = false;
  std::string allow;
};

}  // namespace weir
