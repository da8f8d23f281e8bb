// Writes and parses the messages of other/flexbuf: a FlexBuffers map.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "messages/tensor_message.hpp"

namespace weir::messages {

class FlexbufMessage {
 public:
  static constexpr char kName[] = "flexbuf";
  static constexpr char kCaps[] = "other/flexbuf";

  FlexbufMessage();
  FlexbufMessage(FlexbufMessage&&) noexcept;
  ~FlexbufMessage();

  // Writes a message with NNStreamer's bytes, copying each tensor twice: the library builds it.
  // LIMIT_EXCEEDED.
  Status write(const TensorMessage& message, const ReserveBytes& reserve);
  // Parses and checks a message; the tensors are views of `bytes`. Unknown keys are skipped.
  // Errors: those of check_message().
  Status parse(std::span<const std::byte> bytes, TensorMessage* message);

 private:
  struct Room;  // the builder, reused from frame to frame
  std::unique_ptr<Room> room_;
};

}  // namespace weir::messages
