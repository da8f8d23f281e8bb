// Runs a decoder of messages as the host does, with a frame rate and a format of the stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "decoder_test_support.hpp"

namespace weir::testing_decoders {

struct MessageInput {
  ElementType type;
  std::vector<int64_t> shape;  // outermost first
  Bytes bytes;                 // flexible: with the header
};

struct WrittenMessage {
  std::string caps, error;
  Bytes bytes;
  size_t memories = 0;
};

inline WrittenMessage write_message(const std::string& mode, const Fraction& rate, Format format,
                                    std::vector<MessageInput> inputs) {
  static infer::ModuleLibrary library;
  WrittenMessage out;
  MemorySink sink;
  const auto type = library.decoder(mode);
  auto decoder = type ? infer::Decoder::open(**type, {})
                      : Result<std::unique_ptr<infer::Decoder>>(type.error());
  if (!decoder) return {"", decoder.error().message(), {}};
  EXPECT_TRUE((*decoder)->needs_headers());
  std::vector<weir_tensor> tensors;
  for (auto& input : inputs) {
    weir_tensor tensor{};
    tensor.data = input.bytes.data();
    tensor.bytes = tensor.capacity = input.bytes.size();
    tensor.info.type = static_cast<uint32_t>(input.type);
    tensor.info.rank = static_cast<uint32_t>(input.shape.size());
    std::copy(input.shape.begin(), input.shape.end(), tensor.info.shape);
    tensors.push_back(tensor);
  }
  weir_frame frame{};
  frame.struct_size = sizeof frame;
  frame.n_tensors = static_cast<uint32_t>(tensors.size());
  frame.tensors = tensors.data();
  (*decoder)->set_stream(rate, format);
  if (const auto status = (*decoder)->configure({}, &sink); !status)
    return {"", status.error().message(), {}};
  if (const auto kept = (*decoder)->decode(frame, &sink); !kept)
    return {sink.caps, kept.error().message(), {}};
  return {sink.caps, "", sink.memories.empty() ? Bytes() : sink.memories[0], sink.memories.size()};
}

}  // namespace weir::testing_decoders
