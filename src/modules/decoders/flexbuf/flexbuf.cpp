// flexbuf decoder: writes each frame as one message of other/flexbuf.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flexbuf_message.hpp"
#include "messages/message_decoder.hpp"

using FlexbufDecoder = weir::messages::MessageDecoder<weir::messages::FlexbufMessage>;

WEIR_DECODER(FlexbufDecoder, "flexbuf", "", "[]")
