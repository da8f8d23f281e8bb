// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net-elements/message_codec.hpp"

namespace weir {
namespace {

// A FlatBuffers table without fields: the offset of the table, its vtable of 4 bytes for a table of
// 4 bytes, and the table, which is the offset of the vtable.
constexpr unsigned char kEmptyTable[] = {8, 0, 0, 0, 4, 0, 4, 0, 4, 0, 0, 0};

}  // namespace

Result<MessageCodec> MessageCodec::make(const std::string& idl) {
  MessageCodec out;
  if (idl == messages::ProtobufMessage::kName) return out;
  if (idl == messages::FlatbufMessage::kName) {
    out.format_.emplace<messages::FlatbufMessage>();
    return out;
  }
  return Error{.code = Code::OPTION_VALUE,
               .what = "the schema of the messages is unknown",
               .offered = "idl=" + idl,
               .needed = "protobuf or flatbuf",
               .fix = "idl=protobuf"};
}

const char* MessageCodec::package() const noexcept {
  return format_.index() == 0 ? "nnstreamer.protobuf" : "nnstreamer.flatbuf";
}

std::string MessageCodec::empty() const {
  if (format_.index() == 0) return {};
  return {reinterpret_cast<const char*>(kEmptyTable), sizeof kEmptyTable};
}

}  // namespace weir
