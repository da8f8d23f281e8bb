// The properties of tensor_query_serversrc.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "edge/edge_connect_type.hpp"
#include "gstcpp/element/property.hpp"
#include "weir/result.hpp"

namespace weir {

enum class QueryProtocol : int { Edge = 0, Oip = 1 };
enum class QueryConnectType : int { Tcp = 0, Hybrid = 2 };

struct ServersrcSettings {
  gst::Ref<GstCaps> caps;
  QueryProtocol protocol = QueryProtocol::Edge;
  QueryConnectType connect_type = QueryConnectType::Tcp;
  std::string host = "localhost", dest_host = "127.0.0.1", topic;
  uint32_t port = 3000, dest_port = 1883, id = 0, timeout = 10;
  bool is_live = true;
  std::string model_name, model_version = "1", unix_path;
  uint64_t max_message = uint64_t{64} << 20;
  uint32_t max_requests = 8, max_connections = 32, max_connections_per_address = 4, queue = 64,
           idle_timeout = 300'000;
  uint64_t max_bytes_in_flight = uint64_t{256} << 20;
  bool insecure = false, model_control = false;
  std::string tls_cert, tls_key, tls_ca, tls_peers, token_file;
  std::string user, password, psk, psk_identity;  // for the broker
  WireVersion wire_version = WireVersion::Bytes2088;
  std::string allow;
};

}  // namespace weir

namespace weir::gst {
template <>
struct EnumType<QueryProtocol> {
  static GType type() {
    static const GEnumValue values[] = {{0, "NNStreamer's protocol of query elements", "edge"},
                                        {1, "Open Inference Protocol v2 over gRPC", "oip"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirQueryProtocol", values);
    return t;
  }
};
template <>
struct EnumType<QueryConnectType> {
  static GType type() {
    static const GEnumValue values[] = {{0, "Directly to the address", "TCP"},
                                        {2, "Through an MQTT broker", "HYBRID"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirQueryConnectType", values);
    return t;
  }
};
}  // namespace weir::gst

namespace weir {

// OPTION_VALUE for a connect-type that the protocol does not have.
inline Status check_protocol(QueryProtocol protocol, QueryConnectType connect_type,
                             const char* element) {
  if (connect_type == QueryConnectType::Tcp || protocol != QueryProtocol::Oip) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "protocol=oip does not use a broker",
               .offered = "connect-type=HYBRID protocol=oip",
               .needed = "connect-type=TCP",
               .fix = std::string(element) + " protocol=oip connect-type=TCP"};
}

}  // namespace weir
