// flatbuf decoder: writes each frame as one message of other/flatbuf-tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flatbuf_message.hpp"
#include "messages/message_decoder.hpp"

using FlatbufDecoder = weir::messages::MessageDecoder<weir::messages::FlatbufMessage>;

WEIR_DECODER(FlatbufDecoder, "flatbuf", "", "[]")
