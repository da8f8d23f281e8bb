// Fuzz target: messages of other/flatbuf-tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flatbuf_message.hpp"

#include "message_fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return weir::fuzz::check_message_input<weir::messages::FlatbufMessage>(data, size);
}
