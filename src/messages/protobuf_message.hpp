// Writes and parses the messages of other/protobuf-tensor (tensors.proto).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "messages/tensor_message.hpp"

namespace weir::messages {

struct ProtobufMessage {
  static constexpr char kName[] = "protobuf";
  static constexpr char kCaps[] = "other/protobuf-tensor";

  // Writes the bytes that protobuf's own classes serialise, copying each tensor once.
  // LIMIT_EXCEEDED.
  Status write(const TensorMessage& message, const ReserveBytes& reserve);
  // Parses and checks a message; the tensors are views of `bytes`. Fields may come in any order,
  // unknown ones are skipped. Errors: those of check_message().
  Status parse(std::span<const std::byte> bytes, TensorMessage* message);

 private:
  std::vector<size_t> sizes_;  // of each Tensor; reused from frame to frame
};

}  // namespace weir::messages
