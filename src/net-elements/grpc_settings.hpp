// The properties that both gRPC elements have.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <tuple>

#include "gstcpp/element/property.hpp"
#include "net-elements/message_codec.hpp"
#include "net/tensor_service/tensor_service.hpp"

namespace weir {

struct GrpcSettings {
  bool silent = true;
  bool server = false;
  bool blocking = true;
  std::string idl = "protobuf";
  std::string host = "localhost";
  std::string host_taken = host;  // the last one that was not refused
  int port = 55115;
  uint32_t queue = 16;
  uint64_t max_message = uint64_t{64} << 20;
  uint32_t max_connections = net::TensorServiceOptions().max_connections;
  uint32_t max_connections_per_address = net::TensorServiceOptions().max_address_connections;
  bool insecure = false;
  std::string allow;

  // The connection as the properties describe it. Posts a warning on `element` for another machine
  // without encryption, and later with what degrades the stream. CONNECTION_INSECURE and
  // OPTION_VALUE as of transport::check_old_protocol() and check_server_is_allowed().
  Result<net::TensorServiceOptions> options(const MessageCodec& codec, GstElement* element) const;
};

inline constexpr std::tuple kGrpcProperties{
    gst::Property{"silent", &GrpcSettings::silent, "Accepted for compatibility; has no effect",
                  gst::Changeable::WhilePlaying},
    gst::Property{"idl", &GrpcSettings::idl, "Schema of the messages: protobuf or flatbuf"},
    gst::Property{"host", &GrpcSettings::host,
                  "Address of the server; with server=true, the address to listen on"},
    gst::Property{"port", &GrpcSettings::port,
                  "Port of the server; with server=true, 0 = a free port, which the property "
                  "contains in PAUSED and PLAYING",
                  gst::Changeable::InReady, 0, 65535},
    gst::Property{"max-message", &GrpcSettings::max_message, "Maximum size of a message in bytes",
                  gst::Changeable::InReady, 1024u, 2147483647u},
    gst::Property{"max-connections", &GrpcSettings::max_connections,
                  "With server=true: maximum number of connections with calls in progress; more "
                  "are refused; 0 = no limit"},
    gst::Property{"max-connections-per-address", &GrpcSettings::max_connections_per_address,
                  "As max-connections, for one address; 0 = no limit"},
    gst::Property{"insecure", &GrpcSettings::insecure,
                  "Allow connections to other machines although weir.ini has [network] "
                  "require-tls=true; requires allow"},
    gst::Property{"allow", &GrpcSettings::allow,
                  "Addresses, networks and names of the peers that are allowed, separated by "
                  "commas; default: all"}};

// The pads of both elements.
#define WEIR_CAPS_GRPC \
  WEIR_CAPS_TENSOR     \
  "; other/tensors, "  \
  "format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE

}  // namespace weir
