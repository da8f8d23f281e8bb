// protobuf decoder: writes each frame as one message of other/protobuf-tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/message_decoder.hpp"
#include "messages/protobuf_message.hpp"

using ProtobufDecoder = weir::messages::MessageDecoder<weir::messages::ProtobufMessage>;

WEIR_DECODER(ProtobufDecoder, "protobuf", "", "[]")
