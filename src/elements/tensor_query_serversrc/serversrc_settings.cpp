// Checks and converts the properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_query_serversrc/serversrc_settings.hpp"

namespace weir {

Status check_protocol(QueryProtocol protocol, QueryConnectType connect_type, const char* element) {
  if (connect_type == QueryConnectType::Tcp) return ok();
  const bool is_oip = protocol == QueryProtocol::Oip;
  return Error{.code = Code::OPTION_VALUE,
               .what = is_oip ? "the Open Inference Protocol has no broker"
                              : "brokers are not available yet",
               .offered = is_oip ? "connect-type=HYBRID protocol=oip" : "connect-type=HYBRID",
               .needed = "connect-type=TCP",
               .fix = std::string(element) + (is_oip ? " protocol=oip" : "") + " connect-type=TCP"};
}

}  // namespace weir
