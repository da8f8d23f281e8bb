// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/peer_error.hpp"

#include <utility>

namespace weir::wire {

Error peer_error(std::string what, std::string offered, std::string needed, std::string fix) {
  if (fix.empty()) fix = "check the address, and which program and version runs there";
  return {.code = Code::PEER_MESSAGE_INVALID,
          .what = std::move(what),
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = std::move(fix)};
}

Error peer_error(std::string what, const Error& cause) {
  Error out = peer_error(std::move(what), cause.offered, cause.needed);
  out.difference = cause.difference;
  return out;
}

}  // namespace weir::wire
