// What holds for the messages of every format: an accepted message lies inside of its bytes,
// and is written and parsed again as it was.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

#include "fuzz_input.hpp"
#include "messages/tensor_message.hpp"
#include "weir/module.hpp"

namespace weir::fuzz {

inline bool is_inside(std::span<const std::byte> part, std::span<const std::byte> whole) {
  return part.data() >= whole.data() && part.data() + part.size() <= whole.data() + whole.size();
}

inline bool is_equal(const messages::MessageTensor& a, const messages::MessageTensor& b) {
  return a.type == b.type && a.dimensions == b.dimensions && std::ranges::equal(a.data, b.data);
}

inline void check_accepted(const messages::TensorMessage& message) {
  require(!message.tensors.empty() && message.tensors.size() <= WEIR_TENSOR_LIMIT,
          "a message has 1 to 256 tensors");
  require(message.format == messages::kStatic || message.format == messages::kFlexible,
          "a message is static or flexible");
  const size_t header = message.format == messages::kFlexible ? messages::kHeaderBytes : 0;
  for (const auto& tensor : message.tensors) {
    const auto info = messages::describe_tensor(tensor);
    uint64_t bytes = element_bytes(info.type);
    for (uint32_t i = 0; i < info.rank; ++i)
      require(!__builtin_mul_overflow(bytes, static_cast<uint64_t>(info.shape[i]), &bytes),
              "a tensor has a size");
    require(tensor.data.size() == bytes + header, "a tensor has the bytes of its dimensions");
  }
}

template <class Format>
int check_message_input(const uint8_t* data, size_t size) {
  // At an address that every format reads without a copy, and exactly as long as the input.
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  const std::unique_ptr<std::byte, Free> memory(
      static_cast<std::byte*>(std::malloc(size + (size == 0))));
  std::copy_n(reinterpret_cast<const std::byte*>(data), size, memory.get());
  const std::span<const std::byte> bytes(memory.get(), size);
  Format format;
  messages::TensorMessage message, again;
  if (const auto status = format.parse(bytes, &message); !status) {
    require(!status.error().what.empty() && !status.error().fix.empty(),
            "an error says what to do");
    return 0;
  }
  check_accepted(message);
  for (const auto& tensor : message.tensors)
    require(is_inside(tensor.data, bytes), "a tensor lies inside of its message");
  std::vector<uint64_t> room;
  std::span<std::byte> written;
  const auto reserve = [&](size_t wanted) {
    room.resize(wanted / sizeof(uint64_t) + 1);
    written = std::as_writable_bytes(std::span<uint64_t>(room)).first(wanted);
    return written.data();
  };
  Format other;
  require(other.write(message, reserve).has_value(), "an accepted message can be written");
  require(other.parse(written, &again).has_value(), "a written message can be parsed");
  require(again.rate_n == message.rate_n && again.rate_d == message.rate_d &&
              again.format == message.format &&
              std::ranges::equal(again.tensors, message.tensors, is_equal),
          "a message is written as it was parsed");
  return 0;
}

}  // namespace weir::fuzz
