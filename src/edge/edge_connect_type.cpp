// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edge_connect_type.hpp"

namespace weir {

wire::HeaderForm header_form(WireVersion version) {
  switch (version) {
    case WireVersion::Bytes160:
      return wire::HeaderForm::Bytes160;
    case WireVersion::Bytes168:
      return wire::HeaderForm::Bytes168;
    case WireVersion::Bytes2088:
      break;
  }
  return wire::HeaderForm::Bytes2088;
}

Status check_edge_types(EdgeProtocol protocol, EdgeConnectType connect_type, const char* element) {
  const std::string name = element;
  if (connect_type == EdgeConnectType::Custom)
    return Error{.code = Code::OPTION_VALUE,
                 .what =
                     "connect-type=CUSTOM is not available: the interface of its library is "
                     "not specified",
                 .offered = "connect-type=CUSTOM",
                 .needed = "connect-type=TCP, or protocol=local on one machine",
                 .fix = name + " connect-type=TCP"};
  if (protocol == EdgeProtocol::Local && connect_type != EdgeConnectType::Tcp)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "protocol=local has no broker",
                 .offered = "a connect-type other than TCP",
                 .needed = "protocol=local with path, without connect-type",
                 .fix = name + " protocol=local path=/tmp/weir-stream"};
  return ok();
}

}  // namespace weir
