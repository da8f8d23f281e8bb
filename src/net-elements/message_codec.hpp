// MessageCodec: the messages of one schema (property idl) of the gRPC elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <variant>

#include "messages/flatbuf_message.hpp"
#include "messages/protobuf_message.hpp"

namespace weir {

class MessageCodec {
 public:
  // "protobuf" or "flatbuf"; OPTION_VALUE for another text.
  static Result<MessageCodec> make(const std::string& idl);

  // The package of the schema and of its TensorService.
  const char* package() const noexcept;
  // The bytes of the schema's message Empty.
  std::string empty() const;
  // Writes as ProtobufMessage and FlatbufMessage do.
  Status write(const messages::TensorMessage& message, const messages::ReserveBytes& reserve) {
    return std::visit([&](auto& format) { return format.write(message, reserve); }, format_);
  }
  Status parse(std::span<const std::byte> bytes, messages::TensorMessage* message) {
    return std::visit([&](auto& format) { return format.parse(bytes, message); }, format_);
  }

 private:
  std::variant<messages::ProtobufMessage, messages::FlatbufMessage> format_;
};

}  // namespace weir
