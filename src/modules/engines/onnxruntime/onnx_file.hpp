// What an ONNX file says of itself, read without ONNX Runtime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>

#include "weir/result.hpp"

namespace weir::engine {

struct OnnxSummary {
  int64_t ir_version = 0;
  std::string producer, producer_version;
  std::map<std::string, int64_t> opsets;  // domain ("ai.onnx" for the default) -> version
  std::set<std::string> operators;        // of the graph, its subgraphs and its functions
  std::set<std::string> shapeless;        // inputs and outputs whose rank the file does not say
  uint64_t weight_bytes = 0;              // of the initialisers in the file

  // Some operator's output shape depends on the values in a frame, not on shapes alone.
  bool shapes_depend_on_data() const;
};

// How sure the first bytes make one that this is a model for ONNX Runtime: 0 to 100.
int onnx_score(std::span<const unsigned char> head) noexcept;

// By the first bytes of a file: MODEL_INVALID where the rest need not be read.
Status check_onnx_head(std::span<const std::byte> head);

// Walks the whole file: a file that was cut or damaged in its structure is MODEL_INVALID, and the
// message says where. Weights are not looked at. Field numbers: onnx.proto3 of the ONNX project.
Result<OnnxSummary> read_onnx(std::span<const std::byte> file);

}  // namespace weir::engine
