// The error for what a writer sends and must not.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <utility>

#include "weir/result.hpp"

namespace weir::local {

inline Error bad_writer(std::string sent) {
  return Error{.code = Code::PEER_MESSAGE_INVALID,
               .what = "the edgesink of a local stream sent an invalid message",
               .offered = std::move(sent),
               .needed = "an edgesink of the same version; the connection is closed"};
}

}  // namespace weir::local
