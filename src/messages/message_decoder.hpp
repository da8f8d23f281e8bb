// MessageDecoder: a decoder that writes each frame as one message of `Format`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "messages/tensor_message.hpp"
#include "weir/decoder.hpp"

namespace weir::messages {

// The message is one memory: receivers need not merge memories.
template <class Format>
class MessageDecoder {
 public:
  static constexpr bool kWithHeaders = true;
  explicit MessageDecoder(const Options&) {}

  void set_stream(const DecoderStream& stream) noexcept { stream_ = stream; }
  void configure(std::span<const weir_tensor_info>, DecoderOutput& output) {
    output.set_caps(Format::kCaps);
  }
  bool decode(const weir_frame& frame, DecoderOutput& output) {
    message_.clear();
    message_.rate_n = stream_.rate_n;
    message_.rate_d = stream_.rate_d;
    message_.format = stream_.is_flexible ? kFlexible : kStatic;
    append_tensors(frame, &message_);
    const auto reserve = [&](size_t bytes) { return output.reserve(bytes).data(); };
    if (const auto status = format_.write(message_, reserve); !status)
      throw Failure(status.error());
    return true;
  }

 private:
  DecoderStream stream_;
  TensorMessage message_;
  Format format_;
};

}  // namespace weir::messages
