// ModelBytes: the bytes of the one model that a weir_open names.
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
  std::string path;              // "" when the caller gave bytes
  std::vector<std::byte> owned;  // the file's content
  std::span<const std::byte>
      bytes;  // of `owned`, or the caller's, which are valid only during the call

  std::string name() const { return path.empty() ? "the model given as bytes" : path; }
};

// Conditions on a file that are checked before it is read into memory.
struct ModelLimits {
  // The limit of Protobuf and FlatBuffers, on which most model formats are based.
  uint64_t max = (uint64_t{1} << 31) - 1;
  // Checks the first kModelHead bytes of a file, or all of a shorter one. Null accepts every file.
  Status (*check_head)(std::span<const std::byte> head) = nullptr;
};
inline constexpr size_t kModelHead = 4096;

// The errors of ModelSource::open(); MODEL_UNSUPPORTED for a file above the limit; MODEL_INVALID
// when it is truncated during the read; the error of check_head, with the file's name. Allocates
// memory only as bytes are read.
Result<ModelBytes> read_model(const weir_open& request, const ModelLimits& limits = {});

}  // namespace weir::engine
