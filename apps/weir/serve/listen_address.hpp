// ListenAddress: where `weir serve` listens.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "weir/result.hpp"

namespace weir::app {

struct ListenAddress {
  std::string host, port;  // of TCP; an IPv6 address has no brackets
  std::string unix_path;   // of a Unix socket; then the other two are ""

  // "127.0.0.1:8001", "[::1]:8001", "unix:/run/weir.sock". OPTION_VALUE.
  static Result<ListenAddress> parse(const std::string& text, const char* option);
  std::string text() const;
  // Whether only programs of this machine can connect.
  bool is_local() const;
};

}  // namespace weir::app
