// The custom= options of the engine oip, and the tensors that the user declares.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>

#include "declared_tensors.hpp"
#include "net/client/server_set.hpp"

namespace weir::engine {

struct OipOptions {
  net::RequestLimits limits;
  net::Security security;
  size_t max_bytes = size_t{64} << 20;    // of a message, in either direction
  std::optional<net::Contents> contents;  // empty: raw, and typed if the server refuses that
  bool idempotent = true;                 // false: one request at a time, sent once at most
  DeclaredTensors declared;

  static Result<OipOptions> read(const weir_open& request);
};

}  // namespace weir::engine
