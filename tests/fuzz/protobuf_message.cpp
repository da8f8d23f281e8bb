// Fuzz target: messages of other/protobuf-tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/protobuf_message.hpp"

#include "message_fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return weir::fuzz::check_message_input<weir::messages::ProtobufMessage>(data, size);
}
