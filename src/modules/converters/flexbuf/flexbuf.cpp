// flexbuf converter: the tensors of messages of other/flexbuf.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flexbuf_message.hpp"
#include "messages/message_converter.hpp"

using FlexbufConverter = weir::messages::MessageConverter<weir::messages::FlexbufMessage>;

WEIR_CONVERTER(FlexbufConverter, "flexbuf", "", "other/flexbuf", "[]")
