// How edgesink and edgesrc find each other, and what they speak.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/wire/header_form.hpp"
#include "gstcpp/element/property.hpp"
#include "weir/result.hpp"

namespace weir {

enum class EdgeConnectType : int { Tcp = 0, Mqtt = 1, Hybrid = 2, Custom = 3 };
enum class EdgeProtocol : int { Edge = 0, Local = 1 };

// The version of NNStreamer's library whose headers are sent.
enum class WireVersion : int { Bytes2088 = 0, Bytes168 = 1, Bytes160 = 2 };
wire::HeaderForm header_form(WireVersion version);

// OPTION_VALUE for a combination that is not available, naming those that are.
Status check_edge_types(EdgeProtocol protocol, EdgeConnectType connect_type, const char* element);

}  // namespace weir

namespace weir::gst {
template <>
struct EnumType<EdgeConnectType> {
  static GType type() {
    static const GEnumValue values[] = {
        {0, "Directly to the address of the sink", "TCP"},
        {1, "Frames through an MQTT broker", "MQTT"},
        {2, "Directly, to the address that an MQTT broker stores", "HYBRID"},
        {3, "A user's library (not available)", "CUSTOM"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirEdgeConnectType", values);
    return t;
  }
};
template <>
struct EnumType<EdgeProtocol> {
  static GType type() {
    static const GEnumValue values[] = {
        {0, "NNStreamer's protocol between machines, see connect-type", "edge"},
        {1, "Shared memory between processes of one user, see path", "local"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirEdgeProtocol", values);
    return t;
  }
};
template <>
struct EnumType<WireVersion> {
  static GType type() {
    static const GEnumValue values[] = {{0, "0.2.5 and later: up to 255 memories", "0.2.6"},
                                        {1, "0.2.4: up to 15 memories", "0.2.4"},
                                        {2, "Up to 0.2.3: up to 15 memories", "0.2.2"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirEdgeWireVersion", values);
    return t;
  }
};
}  // namespace weir::gst
