// Maps the blocks that a writer sends. It checks them: a writer is not trusted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

#include "core/isolate/shared_block.hpp"
#include "transport/local/local_socket.hpp"

namespace weir::local {

// Maps `bytes` of a block for reading. The block must be sealed against shrinking: a page that is
// cut off would kill the process that reads it.
// Errors: PEER_MESSAGE_INVALID, OUT_OF_MEMORY.
Result<isolate::Mapping> map_block(const Descriptor& block, uint64_t bytes);

}  // namespace weir::local
