// Errors about bytes that a peer sent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "core/text/shell_quote.hpp"
#include "weir/result.hpp"

namespace weir::wire {

// PEER_MESSAGE_INVALID with these parts. Without `fix` it names the program of the peer.
Error peer_error(std::string what, std::string offered, std::string needed, std::string fix = {});
// The same for a text of a peer that cannot be used for the reason `cause`.
Error peer_error(std::string what, const Error& cause);

using weir::quoted_text;

}  // namespace weir::wire
