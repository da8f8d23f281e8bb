// flatbuf converter: the tensors of messages of other/flatbuf-tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flatbuf_message.hpp"
#include "messages/message_converter.hpp"

using FlatbufConverter = weir::messages::MessageConverter<weir::messages::FlatbufMessage>;

WEIR_CONVERTER(FlatbufConverter, "flatbuf", "",
               "other/flatbuf-tensor, framerate=(fraction)[ 0/1, 2147483647/1 ]", "[]")
