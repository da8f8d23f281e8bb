// The bytes of the one model that a weir_open names, read whole.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

struct ModelBytes {
  std::string path;                  // "" when the caller gave bytes
  std::vector<std::byte> owned;      // of the file
  std::span<const std::byte> bytes;  // of the file, or the caller's: those live for the call only

  std::string name() const { return path.empty() ? "the model given as bytes" : path; }
};

// What a file must be before it is read whole.
struct ModelLimits {
  // Protobuf and FlatBuffers, which most formats of models are, hold no more.
  uint64_t most = (uint64_t{1} << 31) - 1;
  // Refuses a file by its first bytes, of which it gets kModelHead or all. Null accepts every file.
  Status (*check_head)(std::span<const std::byte> head) = nullptr;
};
inline constexpr size_t kModelHead = 4096;

// The errors of ModelSource::open(); MODEL_UNSUPPORTED for a file beyond the limit; MODEL_INVALID
// where it is cut while it is read, and what check_head returns, with the file's name. Memory is
// used for bytes that were read only.
Result<ModelBytes> read_model(const weir_open& request, const ModelLimits& limits = {});

}  // namespace weir::engine
