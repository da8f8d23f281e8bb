// MessageConverter: a converter whose input buffers are messages of `Format`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>
#include <optional>
#include <utility>

#include "messages/tensor_message.hpp"
#include "weir/converter.hpp"

namespace weir::messages {

// Tensors are parts of the message where their elements are aligned in memory, else copies.
template <class Format>
class MessageConverter {
 public:
  explicit MessageConverter(const Options&) {}

  // The messages carry their tensors.
  std::vector<weir_tensor_info> configure(std::string_view) { return {}; }

  bool convert(const weir_frame& frame, ConverterOutput& output) {
    const auto bytes = whole(frame);
    if (const auto status = format_.parse(bytes, &message_); !status) throw Failure(status.error());
    for (const auto& tensor : message_.tensors) add(tensor, frame, output);
    return true;
  }
  std::optional<std::pair<int32_t, int32_t>> rate() const noexcept {
    if (!message_.has_rate()) return std::nullopt;
    return std::pair(message_.rate_n, message_.rate_d);
  }
  bool is_flexible() const noexcept { return message_.format == kFlexible; }

 private:
  static std::span<const std::byte> get_bytes(const weir_tensor& memory) {
    return {static_cast<const std::byte*>(memory.data), static_cast<size_t>(memory.bytes)};
  }

  // A message in several memories is joined.
  std::span<const std::byte> whole(const weir_frame& frame) {
    if (frame.n_tensors == 1) return get_bytes(frame.tensors[0]);
    joined_.clear();
    for (uint32_t i = 0; i < frame.n_tensors; ++i) {
      const auto part = get_bytes(frame.tensors[i]);
      joined_.insert(joined_.end(), part.begin(), part.end());
    }
    return joined_;
  }

  void add(const MessageTensor& tensor, const weir_frame& frame, ConverterOutput& output) const {
    const weir_tensor_info info = describe_tensor(tensor);
    const auto at = reinterpret_cast<uintptr_t>(tensor.data.data());
    const auto begin = reinterpret_cast<uintptr_t>(frame.tensors[0].data);
    const bool of_the_input = at >= begin && at - begin < frame.tensors[0].bytes;
    if (of_the_input && at % element_bytes(tensor.type) == 0)
      return output.share(info, tensor.data);
    const auto to = output.add(info, is_flexible() ? kHeaderBytes : 0);
    std::memcpy(to.data(), tensor.data.data(), to.size());
  }

  Format format_;
  TensorMessage message_;
  std::vector<std::byte> joined_;
};

}  // namespace weir::messages
