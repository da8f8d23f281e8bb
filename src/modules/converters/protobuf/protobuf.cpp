// protobuf converter: the tensors of messages of other/protobuf-tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/message_converter.hpp"
#include "messages/protobuf_message.hpp"

using ProtobufConverter = weir::messages::MessageConverter<weir::messages::ProtobufMessage>;

WEIR_CONVERTER(ProtobufConverter, "protobuf", "",
               "other/protobuf-tensor, framerate=(fraction)[ 0/1, 2147483647/1 ]", "[]")
