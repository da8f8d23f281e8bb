// Reads the properties of a TensorFlow Lite file and checks that TensorFlow Lite can open it
// safely.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir::engine {

struct TfliteSummary {
  std::string description;
  std::span<const std::byte> metadata;  // the buffer TFLITE_METADATA, within the file
  uint32_t subgraphs = 0, operators = 0, tensors = 0;
  bool has_state = false;  // has variable tensors or resource variables, so that results depend on
                           // earlier frames
  bool passes_through = false;         // an output of the graph is an input or a constant
  bool shapes_depend_on_data = false;  // an operator's output shape depends on values
};

// Returns 0 to 100: the confidence that a file with these first bytes is for TensorFlow Lite.
int tflite_score(std::span<const unsigned char> head) noexcept;

// Checks the first bytes of a file: MODEL_INVALID when the rest need not be read.
Status check_tflite_head(std::span<const std::byte> head);

// TensorFlow Lite 2.9 trusts offsets and most indices of a file opened through its C API, and reads
// or writes out of bounds when they are wrong. So this checks everything that it follows: tables,
// vectors and strings are within the file, indices are valid, sizes are possible, each tensor is
// computed before it is used, and subgraphs do not recurse. MODEL_INVALID otherwise. Fields and
// numbers: schema.fbs (version 3) of TensorFlow.
Result<TfliteSummary> read_tflite(std::span<const std::byte> file);

}  // namespace weir::engine
