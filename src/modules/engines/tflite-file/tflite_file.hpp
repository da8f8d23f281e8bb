// What a TensorFlow Lite file says of itself, and whether TensorFlow Lite may be given it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir::engine {

struct TfliteSummary {
  std::string description;
  std::span<const std::byte> metadata;  // the buffer TFLITE_METADATA, within the file
  uint32_t subgraphs = 0, operators = 0, tensors = 0;
  bool has_state = false;  // variable tensors or resource variables: the past changes the result
  bool passes_through = false;         // an output of the graph is an input or a constant
  bool shapes_depend_on_data = false;  // an operator's output shape depends on values
};

// How sure the first bytes make one that this is a model for TensorFlow Lite: 0 to 100.
int tflite_score(std::span<const unsigned char> head) noexcept;

// By the first bytes of a file: MODEL_INVALID where the rest need not be read.
Status check_tflite_head(std::span<const std::byte> head);

// TensorFlow Lite 2.9 trusts offsets and most indices of a file that is opened through its C API,
// and reads or writes anywhere when they lie. So all that it follows is checked before: every
// table, vector and string lies within the file, every index names something, sizes are possible,
// each tensor is made before it is used, subgraphs do not call themselves. MODEL_INVALID otherwise.
// Fields and numbers: schema.fbs (version 3) of TensorFlow.
Result<TfliteSummary> read_tflite(std::span<const std::byte> file);

}  // namespace weir::engine
