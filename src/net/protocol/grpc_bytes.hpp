// Messages as gRPC's byte buffers. Only the files that use gRPC include this.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <optional>

#include "net/protocol/oip_messages.hpp"

namespace weir::net {

// A message that was received, in the memory in which it arrived.
struct ReceivedMessage {
  Chunks chunks;
  std::shared_ptr<const void> memory;  // of the chunks
};

// The pieces as one message. What they borrow is sent from where it is; `memory` is held until gRPC
// has released the last of it.
grpc::ByteBuffer make_message(const Pieces& pieces, const std::shared_ptr<const void>& memory);
// nullopt when gRPC cannot read the buffer.
std::optional<ReceivedMessage> received(const grpc::ByteBuffer& message);

}  // namespace weir::net
