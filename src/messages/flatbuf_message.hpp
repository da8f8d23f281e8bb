// Writes and parses the messages of other/flatbuf-tensor (tensors.fbs).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "messages/tensor_message.hpp"

namespace weir::messages {

class FlatbufMessage {
 public:
  static constexpr char kName[] = "flatbuf";
  static constexpr char kCaps[] = "other/flatbuf-tensor";

  FlatbufMessage();
  FlatbufMessage(FlatbufMessage&&) noexcept;
  ~FlatbufMessage();

  // Writes a message whose tensors begin at multiples of 64 bytes, copying each once.
  // LIMIT_EXCEEDED.
  Status write(const TensorMessage& message, const ReserveBytes& reserve);
  // Verifies and checks a message; the tensors are views of `bytes`, or of a copy of it, valid
  // until the next call, when `bytes` does not begin at a multiple of 8. Errors: those of
  // check_message().
  Status parse(std::span<const std::byte> bytes, TensorMessage* message);

 private:
  struct Room;  // the builder and the copy, reused from frame to frame
  std::unique_ptr<Room> room_;
};

}  // namespace weir::messages
