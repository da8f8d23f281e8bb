// TensorMessage: the content of a protobuf, FlatBuffers or FlexBuffers message, which holds one
// frame of a tensor stream (docs/compatibility/io.md 7.7), and the checks that all formats share.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::messages {

inline constexpr size_t kHeaderBytes = 128;            // in front of each flexible tensor
inline constexpr uint64_t kMessageLimit = 0x7FFFFFFF;  // of protobuf and FlatBuffers: 2 GiB - 1

enum Format : uint32_t { kStatic = 0, kFlexible = 1, kSparse = 2 };

struct MessageTensor {
  uint32_t type = WEIR_TYPE_END;
  std::array<uint32_t, WEIR_RANK_LIMIT> dimensions{};  // innermost first, 0 = unused
  std::span<const std::byte> data;                     // flexible: with the header
};

// Copied for each tensor that is read: at -O2, GCC clears a new one with an instruction that takes
// longer than all of the reading.
inline const MessageTensor kNoTensor;

struct TensorMessage {
  int32_t rate_n = 0, rate_d = 0;  // 0/0 or -1/-1: the message has no frame rate
  uint32_t format = kStatic;
  std::vector<MessageTensor> tensors;

  void clear() noexcept {
    rate_n = rate_d = 0;
    format = kStatic;
    tensors.clear();
  }
  bool has_rate() const noexcept { return rate_n >= 0 && rate_d > 0; }
};

// Returns memory of exactly this size for a message, aligned to 64 bytes. May throw.
using ReserveBytes = std::function<std::byte*(size_t bytes)>;

// Appends the tensors of a frame, without copying their bytes.
void append_tensors(const weir_frame& frame, TensorMessage* message);
// The ABI's description of a tensor of a checked message.
weir_tensor_info describe_tensor(const MessageTensor& tensor) noexcept;

// The bytes of all elements, UINT64_MAX beyond 64 bits; nullopt without a dimension and for values
// after a 0.
std::optional<uint64_t> count_bytes(const MessageTensor& tensor);
// LIMIT_EXCEEDED when a message of `bytes` is too large for its format.
Status check_size(const char* format_name, uint64_t bytes);
// Checks what every format has in common: the declared and the real count, the limit of 256
// tensors, types, dimensions, sizes, format and frame rate. `message_bytes` limits the sum of all
// tensors: tensors of a message do not overlap. Errors: HEADER_INVALID, LIMIT_EXCEEDED,
// FORMAT_UNSUPPORTED.
Status check_message(const char* format_name, uint64_t declared_count, size_t message_bytes,
                     const TensorMessage& message);
// HEADER_INVALID: bytes that are no message of this format.
Error damaged_message(const char* format_name, std::string what, std::string offered,
                      std::string needed);
// LIMIT_EXCEEDED: more than 256 tensors.
Error too_many_tensors(const char* format_name, uint64_t count);

}  // namespace weir::messages
