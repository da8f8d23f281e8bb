// The calls from a pipeline to its worker process as messages, field by field.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/isolate/message.hpp"
#include "weir/abi.h"

namespace weir::isolate {

struct OpenCall {
  std::string engine;  // name or alias; "" = chosen by the model's files
  std::vector<std::string> paths;
  std::vector<std::pair<std::string, std::string>> options;
  std::string accelerator;
  int32_t threads = 0;
  std::vector<std::pair<std::string, std::string>> declared;  // infer::OpenOptions::declared

  void put(MessageWriter* message) const;
  static OpenCall take(MessageReader* message);
};

// A copy without addresses, which have no meaning in the other process.
weir_tensor without_pointers(const weir_tensor& tensor);
// True if the rank allows the shape to be read.
bool has_legal_rank(const weir_tensor_info& info) noexcept;

struct BlockCall {
  uint64_t id, bytes;
  uint32_t writable;
};

inline constexpr uint32_t kMaxMaps = 1 << 16;

// Part of Invoke: the frame, then each tensor, as ABI structs without their pointers.
struct FrameCall {
  int64_t pts, duration, deadline;
  uint64_t stream_id, sequence;
  uint32_t flags, maps, maps_of;  // each weir_source_map follows
  uint64_t output_block;          // for the results
  uint32_t inputs, outputs;
};
struct InputCall {
  uint64_t block, offset;
  weir_tensor tensor;
};
struct OutputCall {
  uint64_t offset;
  uint32_t given;  // 0: the engine allocates
  weir_tensor tensor;
};

// Part of Invoked: the return value of the engine; whether all outputs that it allocated are
// already in the block (after the given outputs, each at a multiple of kPlacement); then a tensor
// for each output.
struct InvokeResponse {
  int32_t result;
  uint32_t in_block, outputs;
};
struct OutputResponse {
  uint64_t bytes;
  weir_tensor_info info;
};
inline constexpr uint64_t kPlacement = 4096;
// The next place for `bytes` at or after `end`; advances `end` beyond it. Nullopt beyond 63 bits.
std::optional<uint64_t> place(uint64_t bytes, uint64_t* end);

}  // namespace weir::isolate
