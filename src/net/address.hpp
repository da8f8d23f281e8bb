// ServerAddress: where a model is served, as users write it.
//
//   grpc://127.0.0.1:8001/resnet/1        plain, for this machine
//   grpcs://host:8001/resnet              TLS, any version of the model
//   grpc+unix:/run/weir.sock:/resnet      a Unix socket
//   grpcs:dns:///farm.example:8001/resnet     one name with several addresses
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::net {

struct ServerAddress {
  std::string text;        // as written, for errors and logs
  std::string target;      // gRPC's name of it: "127.0.0.1:8001", "unix:/run/weir.sock"
  std::string model;       // name of the model on the server
  std::string version;     // "" = the server chooses
  bool encrypted = false;  // TLS
  bool local = false;      // loopback or a Unix socket

  // OPTION_VALUE for a text of another form.
  static Result<ServerAddress> parse(std::string_view text);
};

}  // namespace weir::net
