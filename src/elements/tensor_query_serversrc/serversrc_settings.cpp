// Checks and converts the properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_query_serversrc/serversrc_settings.hpp"

namespace weir {

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
