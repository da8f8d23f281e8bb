// Errors about bytes that a peer sent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::wire {

// PEER_MESSAGE_INVALID with these parts. Without `fix` it names the program of the peer.
Error peer_error(std::string what, std::string offered, std::string needed, std::string fix = {});

// Text of a peer in quotes: at most 64 characters of printable ASCII, other bytes as \xNN.
std::string quoted_text(std::string_view text);

}  // namespace weir::wire
