// The properties that both gRPC elements have.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "elements/tensor_sink_grpc/message_codec.hpp"
#include "gstcpp/element/property.hpp"
#include "net/tensor_service.hpp"

namespace weir {

struct GrpcSettings {
  bool silent = true;
  bool server = false;
  bool blocking = true;
  std::string idl = "protobuf";
  std::string host = "localhost";
  int port = 55115;
  uint32_t queue = 16;
  uint64_t max_message = uint64_t{64} << 20;
  bool insecure = false;
  std::string allow;

  // The connection as the properties describe it. Posts a warning on `element` for another machine
  // without encryption, and later with what degrades the stream. CONNECTION_INSECURE and
  // OPTION_VALUE as of transport::check_old_protocol().
  Result<net::TensorServiceOptions> options(const MessageCodec& codec, GstElement* element) const;
};

// The pads of both elements.
#define WEIR_CAPS_GRPC \
  WEIR_CAPS_TENSOR     \
  "; other/tensors, "  \
  "format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE

}  // namespace weir
