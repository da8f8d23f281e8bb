// Takes the outputs of an answer into a frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "net/link.hpp"
#include "oip/oip_signature.hpp"

namespace weir::engine {

// Copies the outputs into the memory of `frame`, or into memory of the host where it has none, and
// increases `copied` by their bytes. `times`: those of the answer, if it has any.
// PEER_MESSAGE_INVALID for outputs other than the expected ones.
Status take_outputs(const net::Reply& reply, const std::vector<OipTensor>& expected,
                    const weir_frame& frame, uint64_t* copied,
                    std::optional<net::AnswerTimes>* times);

}  // namespace weir::engine
