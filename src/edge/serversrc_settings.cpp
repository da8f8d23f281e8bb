// Checks and converts the properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/serversrc_settings.hpp"

namespace weir {

Status check_protocol(QueryProtocol protocol, QueryConnectType connect_type, const char* element) {
  if (connect_type == QueryConnectType::Tcp || protocol != QueryProtocol::Oip) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "protocol=oip does not use a broker",
               .offered = "connect-type=HYBRID protocol=oip",
               .needed = "connect-type=TCP",
               .fix = std::string(element) + " protocol=oip connect-type=TCP"};
}

}  // namespace weir
