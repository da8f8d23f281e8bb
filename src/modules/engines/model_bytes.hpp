// The bytes of the one model that a weir_open names, read whole.
#pragma once
#include <cstddef>
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

// MODEL_NOT_FOUND, or MODEL_INVALID for a folder and an empty file; SPEC_MISMATCH unless there is
// exactly one model.
Result<ModelBytes> read_model(const weir_open& request);

}  // namespace weir::engine
